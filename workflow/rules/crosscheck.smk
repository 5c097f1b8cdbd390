# Another code, run as an outside program by its own Python, solves every window again; the report shows both.
if PLAN.common["crosscheck"]["code"] != "none":

    rule crosscheck:
        """Solve the same problem by another code, compare, and draw the panel with it."""
        input:
            unpack(files_of_panel),
            program=PACKAGE / "crosscheck/outside.py",
        output:
            crosscheck=f"{PLAN.folder}/crosscheck.nc",
            panel=f"{PLAN.folder}/panel-crosschecked.html",
            summary=f"{PLAN.folder}/panel-crosschecked.json",
        log:
            f"{PLAN.logs}/crosscheck.log",
        wildcard_constraints:
            surface=one_of(PLAN.solved),
        conda:
            "../envs/roughcontact.yaml"
        resources:
            **needs_of("crosscheck"),
        params:
            settings=of(PLAN.settings, "statistics"),
            crosscheck=PLAN.common["crosscheck"],
            code=code("crosscheck"),
        script:
            "../scripts/crosscheck.py"
