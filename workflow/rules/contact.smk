rule uncertainty:
    """Ask how far the results may be off, source by source."""
    input:
        window=stage_file("window"),
        levelled=stage_file("levelled"),
    output:
        f"{FOLDER}/uncertainty.nc",
    log:
        f"{LOGS}/uncertainty.log",
    wildcard_constraints:
        surface=stagewise(SOLVED),
        case=owners("uncertainty"),
    group:
        "surface"
    conda:
        "../envs/roughcontact.yaml"
    threads: solver_threads
    resources:
        mem_mb=memory(bytes_per_point=115, up_to_a_million=1000),
        runtime=minutes(microseconds_per_point=100, and_load=150),
    params:
        settings=stage_settings("uncertainty"),
        code=code("uncertainty"),
    script:
        "../scripts/uncertainty.py"


# A case that keeps its fields has two jobs: the solution, and what is counted in it. Without fields there is one job
# that counts while it solves, since nothing would be left to count in.
if owners("contact", keep_fields=True) or (
    not STUDY and CASES[""]["contact"]["keep_fields"]
):

    rule solve:
        """Solve the contact problem for every load."""
        input:
            stage_file("window"),
        output:
            f"{FOLDER}/contact.nc",
        log:
            f"{LOGS}/solve.log",
        wildcard_constraints:
            surface=stagewise(SOLVED),
            case=owners("contact", keep_fields=True),
        group:
            "surface"
        conda:
            "../envs/roughcontact.yaml"
        threads: solver_threads
        resources:
            mem_mb=memory(bytes_per_point=80),
            runtime=minutes(microseconds_per_point=20, and_load=30),
        params:
            settings=stage_settings("contact"),
            code=code("solve"),
        script:
            "../scripts/solve.py"

    rule statistics:
        """Count what is in the contact: areas, pressures, gaps, clusters."""
        input:
            contact=stage_file("contact"),
            uncertainty=stage_file("uncertainty"),
        output:
            shown("statistics"),
        log:
            f"{LOGS}/statistics.log",
        wildcard_constraints:
            surface=stagewise(SOLVED),
            case=owners("statistics", keep_fields=True),
        group:
            "surface"
        conda:
            "../envs/roughcontact.yaml"
        threads: solver_threads
        resources:
            mem_mb=memory(bytes_per_point=80, and_flow=1600),
            runtime=minutes(microseconds_per_point=100, and_load=10),
        params:
            settings=stage_settings("statistics"),
            code=code("statistics"),
        script:
            "../scripts/statistics.py"


if owners("contact", keep_fields=False) or (
    not STUDY and not CASES[""]["contact"]["keep_fields"]
):

    rule solve_statistics:
        """Solve the contact problem for every load and count at once; the fields are not kept."""
        input:
            window=stage_file("window"),
            uncertainty=stage_file("uncertainty"),
        output:
            contact=f"{FOLDER}/contact.nc",
            statistics=shown("statistics"),
        log:
            f"{LOGS}/solve_statistics.log",
        wildcard_constraints:
            surface=stagewise(SOLVED),
            case=owners("contact", keep_fields=False),
        group:
            "surface"
        conda:
            "../envs/roughcontact.yaml"
        threads: solver_threads
        resources:
            mem_mb=memory(bytes_per_point=500, and_flow=1600),
            runtime=minutes(microseconds_per_point=20, and_load=40),
        params:
            settings=stage_settings("statistics"),
            code=code("solve_statistics"),
        script:
            "../scripts/solve_statistics.py"
