#!/usr/bin/env bash
# Run the workflow through SLURM, on a one-node cluster that this script starts and stops.
#
#     sudo apt-get install slurm-wlm munge
#     sudo env PATH="$PWD/.venv/bin:$PATH" tests/workflow/slurm.sh
#
# Needs root (the daemons), snakemake on the path, and a machine without a SLURM of its own. Everything lies in a
# temporary folder, on the loopback address, with a key of its own and no accounting. Takes some minutes.
set -euo pipefail

checkout=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d -t slurm.XXXXXX)
chmod 755 "$folder"
daemons=()
stop() {
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
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ReturnToService=2
MpiDefault=none
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
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

# a small map through all stages
mkdir "$folder/run"
python - "$folder/run" <<'PYTHON'
import sys
from pathlib import Path

import numpy as np

folder = Path(sys.argv[1])
x = np.linspace(0, 2 * np.pi, 48, endpoint=False)
np.save(folder / "wave.npy", np.cos(3 * x)[:, None] * np.cos(2 * x))
(folder / "surfaces.tsv").write_text("surface\tpath\tunit\tdx\tdy\nwave\twave.npy\tum\t5\t5\n")
(folder / "settings.yaml").write_text("surfaces: surfaces.tsv\ncontact: {contact_modulus: 1e9}\n")
PYTHON
snakemake --snakefile "$checkout/Snakefile" --workflow-profile "$checkout/workflow/profiles/slurm" \
    --directory "$folder/run" --configfile "$folder/run/settings.yaml" \
    --slurm-no-account --slurm-status-command squeue --slurm-keep-successful-logs \
    --slurm-init-seconds-before-status-checks 3 --seconds-between-status-checks 3 --latency-wait 5 "$@" ||
    { cat "$folder"/run/.snakemake/slurm_logs/*/*/*.log; exit 1; }

[ -s "$folder/run/results/report.html" ] || { echo "no report"; exit 1; }
echo "the workflow ran through SLURM:" "$folder"/run/.snakemake/slurm_logs/*
