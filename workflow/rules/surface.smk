rule ingest:
    """Read the measured file into SI units."""
    input:
        measured_file,
    output:
        f"{FOLDER}/height.nc",
    log:
        f"{LOGS}/ingest.log",
    wildcard_constraints:
        surface=stagewise(MEASURED),
        case=owners("height"),
    priority: 1  # before all others, so that every file that cannot be read is known soon
    group:
        "surface"
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=lambda wildcards, attempt: round(
            attempt * (BASE_MEMORY + reading_memory(MEASURED[wildcards.surface].path))
        ),
        runtime=lambda wildcards, attempt: round(
            5 + attempt * megabytes(MEASURED[wildcards.surface].path) / 100
        ),
    params:
        settings=stage_settings("height"),
        file=place_in_table,
        future=from_the_future,
        code=code("ingest"),
    script:
        "../scripts/ingest.py"


rule level:
    """Remove form and outliers, fill in missing points."""
    input:
        stage_file("height"),
    output:
        f"{FOLDER}/levelled.nc",
    log:
        f"{LOGS}/level.log",
    wildcard_constraints:
        surface=stagewise(MEASURED),
        case=owners("levelled"),
    group:
        "surface"
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=memory(bytes_per_point=90),
        runtime=minutes(microseconds_per_point=20),
    params:
        settings=stage_settings("levelled"),
        code=code("level"),
    script:
        "../scripts/level.py"


if MEMBERS:

    rule composite:
        """Lay the two faces of a pair on one another and sum their heights."""
        input:
            levelled_faces,
        output:
            f"{FOLDER}/levelled.nc",
        log:
            f"{LOGS}/composite.log",
        wildcard_constraints:
            surface=stagewise(MEMBERS),
            case=owners("levelled"),
        group:
            "surface"
        conda:
            "../envs/roughcontact.yaml"
        resources:
            mem_mb=memory(bytes_per_point=400),
            runtime=minutes(microseconds_per_point=20),
        params:
            settings=stage_settings("levelled"),
            code=code("composite"),
        script:
            "../scripts/composite.py"


rule window:
    """Cut out a window without missing points and make it periodic."""
    input:
        stage_file("levelled"),
    output:
        f"{FOLDER}/window.nc",
    log:
        f"{LOGS}/window.log",
    wildcard_constraints:
        surface=stagewise([*MEASURED, *MEMBERS]),
        case=owners("window"),
    group:
        "surface"
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=memory(bytes_per_point=90),
        runtime=minutes(microseconds_per_point=20),
    params:
        settings=stage_settings("window"),
        code=code("window"),
    script:
        "../scripts/window.py"
