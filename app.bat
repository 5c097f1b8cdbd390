@echo off
rem Double-click it on Windows, or drop a folder on it: installs what is missing, and opens the study there.
if "%~1"=="" (set "folder=%~dp0study") else (set "folder=%~1")
py "%~dp0run.py" app "%folder%"
if errorlevel 1 pause
