#!/usr/bin/env bash
# Run the samples through SLURM by the command of docs/how-to/cluster.md, on a one-node cluster that this script
# starts and stops. The cluster keeps no accounts, and kills a job that takes more memory than it asked for.
#
#     sudo apt-get install slurm-wlm munge
#     sudo tests/workflow/slurm.sh                  # with the environment of run.py, .venv
#     sudo tests/workflow/slurm.sh .venv-lowest     # with another one, here that of `run.py lowest`
#
# Needs root (the daemons), the environment, and a machine without a SLURM of its own. Everything lies in
# a temporary folder, on the loopback address, with a key of its own. Takes some minutes.
set -euo pipefail

checkout=$(cd "$(dirname "$0")/../.." && pwd)
environment=$(cd "${1:-$checkout/.venv}" && pwd)
# of a name that nobody can foresee and link elsewhere (this runs as root); all users of SLURM look into it
folder=$(mktemp -d -t slurm.XXXXXX)
chmod 755 "$folder"
daemons=()
stop() {
    scancel --signal=KILL --full --user="$(id -un)" 2>/dev/null || true  # jobs of a run that was interrupted
    for daemon in "${daemons[@]}"; do kill "$daemon" 2>/dev/null || true; done
    wait
    if [ "$(readlink /etc/slurm/slurm.conf)" = "$folder/slurm.conf" ]; then rm /etc/slurm/slurm.conf; fi
    rm -rf "$folder"
}
trap stop EXIT

# authentication
mkdir -m 755 "$folder/munge"
dd if=/dev/urandom of="$folder/munge/key" bs=1024 count=1 status=none
chmod 600 "$folder/munge/key"
munged --foreground --force --socket="$folder/munge/socket" --key-file="$folder/munge/key" \
    --pid-file="$folder/munge/pid" --seed-file="$folder/munge/seed" --log-file="$folder/munge/log" 2>/dev/null &
daemons+=($!)

# one node: this machine, with its cores and its memory
[ ! -e /etc/slurm/slurm.conf ] || { echo "this machine has a SLURM of its own"; exit 1; }
mkdir -p /etc/slurm
ln -s "$folder/slurm.conf" /etc/slurm/slurm.conf  # Snakemake takes SLURM_CONF out of a job's environment
mkdir "$folder/state" "$folder/spool"
memory=$(awk '/MemTotal/ {print int($2 / 1024)}' /proc/meminfo)
cat >"$folder/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=26817
SlurmdPort=26818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CredType=cred/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill,UsePss
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
MpiDefault=none
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc --all) RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
until [ -S "$folder/munge/socket" ]; do sleep 0.1; done
slurmctld -D >/dev/null 2>&1 &
daemons+=($!)
slurmd -D >/dev/null 2>&1 &
daemons+=($!)
for _ in $(seq 60); do
    [ "$(sinfo --noheader --format=%t 2>/dev/null)" = idle ] && break
    sleep 1
done
sinfo --noheader --format=%t | grep -q idle || { tail "$folder"/*.log; echo "the node does not come up"; exit 1; }

# by the command of the page, in a folder with what it names
mkdir "$folder/run"
cd "$folder/run"
cp -r "$checkout/config" "$checkout/data_samples" "$checkout/Snakefile" "$checkout/workflow" .
ln -s "$environment" .venv  # the name that the page has
cp config/config.yaml my.yaml
# no job takes for code what lies beside the maps
for name in yaml random numpy xarray snakemake roughcontact; do
    echo "open('$folder/executed', 'a').write(__file__ + '\\n'); raise SystemExit(1)" >"$name.py"
done
command=$(sed -n '/^```bash/,/^```/{/^```/d;p}' "$checkout/docs/how-to/cluster.md" | grep -B1 slurm-no-account)
killed() { cat "$folder"/slurmd.log $(find .snakemake/slurm_logs -name "*.log") 2>/dev/null | grep -ci "exceeded .*memory limit" || true; }
submitted() { grep -c "_slurm_rpc_submit_batch_job" "$folder/slurmctld.log"; } # arrays count once
show() {
    tail -n 40 "$folder/said"
    cat $(find .snakemake/slurm_logs -name "*.log") 2>/dev/null | tail -n 40
    exit 1
}
run() {
    echo "$command" "$@"
    bash -eu -c "$command ${*@Q}" >"$folder/said" 2>&1
}
run || show
[ -s results/report.html ] || show
[ ! -e "$folder/executed" ] || { cat "$folder/executed"; exit 1; }
echo "the samples ran through SLURM: $(squeue --version), $(submitted) jobs, $(killed) killed for want of memory"
[ "$(killed)" = 0 ]
[ "$(submitted)" = 19 ] # three for each of six surfaces, and the report

# jobs that ask for too little at first: they are killed, say why and are tried again, while the others go on
rm -r results
sed -n '/^surface/p;/^periodic/p;/^stylus/p' config/surfaces.tsv >"$folder/two" && mv "$folder/two" config/surfaces.tsv
little="700 if 'stylus' in str(output) else 100 * attempt ** 3"
run --set-resources "prepare:mem_mb=$little" "contact:mem_mb=$little" || show
[ -s results/report.html ] || show
grep "^\[prepare periodic\] ERROR: killed, took more memory than the 100 MB it had asked for" "$folder/said"
grep "^\[prepare periodic\] is tried again with 800 MB" "$folder/said"
[ "$(killed)" != 0 ]

# four small maps, one of them without a point: the report has the others and says what it lacks
rm -r results .snakemake
mkdir maps
"$environment/bin/python" -P - >config/surfaces.tsv <<'PYTHON'
import numpy as np

print("surface", "path", "unit", "dx", "dy", sep="\t")
for number in range(4):
    heights = np.random.default_rng(number).normal(size=(64, 64)) if number != 2 else np.full((64, 64), np.nan)
    np.save(f"maps/{number}.npy", heights)
    print(f"s{number}", f"maps/{number}.npy", "nm", 1, 1, sep="\t")
PYTHON
complete() {
    [ "$(cut -d, -f1 results/summary.csv | grep -c "^s[0-9]*$")" -ge 4 ] || show
    for number in 0 1 3; do [ -s "results/s$number/statistics.nc" ] || show; done
    [ -s results/report.html ] || show
    grep -q "^\[prepare s2\] ERROR: maps/2.npy: all 4096 points of the map are missing" "$folder/said" || show
    grep -q "^Not finished: s2\. " "$folder/said" || show
}
run && show
grep "ERROR" "$folder/said"
complete

# all of it as a single job, as the page says for many small maps
rm -r results logs .snakemake
one=$(sed -n '/^```bash/,/^```/{/^```/d;p}' "$checkout/docs/how-to/cluster.md" | grep "^sbatch")
echo "$one"
PATH="$environment/bin:$PATH" bash -eu -c "${one/32/2}" && show
cat slurm-*.out >"$folder/said"
complete
echo "four small maps, one of them bad, ran through SLURM, one by one and as a single job"
