# Another code, run as an outside program by its own Python, solves every window again; the report shows both.
if CROSSCHECK["code"] != "none":

    rule crosscheck:
        """Solve the same problem by another code and compare."""
        input:
            window=stage_file("window"),
            contact=stage_file("contact"),
            statistics=stage_file("statistics"),
            program=PACKAGE / "crosscheck/outside.py",
        output:
            f"{FOLDER}/crosscheck.nc",
        log:
            f"{LOGS}/crosscheck.log",
        group:
            "surface"
        conda:
            "../envs/roughcontact.yaml"
        resources:
            mem_mb=memory(bytes_per_point=600, and_load=50),
            runtime=minutes(microseconds_per_point=20, and_load=1000),
        params:
            settings=stage_settings("statistics"),
            crosscheck=CROSSCHECK,
            code=code("crosscheck"),
        script:
            "../scripts/crosscheck.py"
