# Small maps: the stages of a surface in two jobs, up to the window and from there. A job that fails takes its own part
# of its own surface (under its own case) along, nothing else; the window stays where the contact has failed.
# A case that reads nothing and prepares for itself alone, as one with a window of its own, does it in the second job.
PARTS = {
    "prepare": {
        "": ["ingest", "level", "window"],
        "_faces": ["ingest", "level"],
        "_members": ["composite", "window"],
    },
    "contact": dict.fromkeys(
        ("", "_members"),
        ["uncertainty", "solve", "statistics", "solve_statistics", "panel"],
    ),
}


def scripts_of(case, part, kind):
    """Return the scripts of one part that a case runs itself, in whichever job."""
    left_out = (
        {"solve_statistics"}
        if CASES[case]["contact"]["keep_fields"]
        else {"solve", "statistics"}
    ) | ({"panel"} if CROSSCHECK["code"] != "none" else set())
    return [
        step
        for step in PARTS[part].get(kind, [])
        if step not in left_out
        and all(
            OWNERS[stage][case] == case
            for stage in STEPS[step].outputs
            if stage in SECTIONS
        )
    ]


def own_steps(case, part, kind):
    """Return the scripts that the job of one part of a case runs."""
    prepare = scripts_of(case, "prepare", kind)
    written = {name for step in prepare for name in STEPS[step].outputs}
    others = {SHARED[other].get(stage) for other in CASES for stage in written}
    if {"ingest", "composite"} & {*prepare} or case in others or kind == "_faces":
        return scripts_of(case, part, kind)
    return prepare + scripts_of(case, part, kind) if part == "contact" else []


def linked_stages(case, part, kind):
    """Return the stages that a part takes from other cases; the second one also those of a first without scripts."""
    stages = {
        STEPS[step].outputs[0]: None
        for each in PARTS
        if kind in PARTS[each]
        and (each == part or (part == "contact" and not own_steps(case, each, kind)))
        for step in PARTS[each][kind]
    }
    if part == "prepare" and kind != "_faces" and not own_steps(case, part, kind):
        return []
    return [stage for stage in stages if stage in SHARED[case]]


def files_of_steps(steps, links):
    """Return the input function that names the files which scripts read and do not write, and those to be linked."""
    written = {name for step in steps for name in STEPS[step].outputs}
    read = {name for step in steps for name in STEPS[step].inputs} - written

    @called_often
    def files(wildcards):
        special = {
            "measured": measured_file,
            "counter_face": counter_face,
            "face": lambda wildcards: levelled_faces(wildcards)[0],
            "facing": lambda wildcards: levelled_faces(wildcards)[1],
        }
        return {
            name: special.get(name, stage_file(name))(wildcards)
            for name in sorted(read | set(links))
        }

    return files


def settings_of_steps(steps):
    """Return the parameter function that gives the settings of each script."""
    of_each = {step: stage_settings(STEPS[step].stage) for step in steps}
    return called_often(
        lambda wildcards: {
            step: of_step(wildcards) for step, of_step in of_each.items()
        }
    )


# that of the stage that takes most
small_memory = memory(bytes_per_point=500, and_flow=1600, up_to_a_million=1000)


@called_often
def small_minutes(wildcards, attempt):
    """Return the run time (minutes) of a job with several stages of a small map."""
    return round(attempt * (1 + 1.5 * megabytes(row(wildcards.surface).path)))


for case in CASES:
    for part, kinds in PARTS.items():
        for kind in kinds:
            small = [surface for surface in STAGES[kind][0] if surface in SMALL]
            steps, links = own_steps(case, part, kind), linked_stages(case, part, kind)
            written = [name for step in steps for name in STEPS[step].outputs]
            if small and (steps or links):

                rule:
                    name:
                        "_".join(filter(None, (part, case))) + kind
                    # takes a small map through several stages
                    input:
                        unpack(files_of_steps(steps, links)),
                    output:
                        **{
                            file: (
                                shown(file)
                                if file in SHOWN and file in written
                                else f"{FOLDER}/{file}.nc"
                            )
                            for file in [*written, *links]
                        },
                    log:
                        **{step: f"{LOGS}/{step}.log" for step in steps or ["share"]},
                    wildcard_constraints:
                        surface=one_of(small),
                        case=case,
                    # before all others, so that every file that cannot be read is known soon
                    priority: int(part == "prepare")
                    group:
                        "small_surfaces"
                    conda:
                        "../envs/roughcontact.yaml"
                    resources:
                        mem_mb=small_memory,
                        runtime=small_minutes,
                        # of a batch on a cluster one at a time, which has the memory of one
                        small_surfaces=1,
                    params:
                        **(
                            {"file": place_in_table, "future": from_the_future}
                            if "ingest" in steps
                            else {}
                        ),
                        steps=steps,
                        links=links,
                        settings=settings_of_steps(steps),
                        code={step: code(step) for step in [*steps, "together"]},
                    script:
                        "../scripts/together.py"
