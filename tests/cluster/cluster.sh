#!/bin/bash
# Workers on a cluster: Debian's Slurm with two nodes on this machine. They are requeued, signalled and
# lose their node, and what they leave is, byte for byte, what one process makes alone.
#
# usage: cluster.sh PROGRAM
set -euo pipefail
program=$(realpath "$1")
cd "$(dirname "$0")/../.."
dir=$(mktemp -d)
chmod 755 "$dir"
export SLURM_CONF=$dir/slurm.conf
what=(tests/experiments/crawler.toml --set sweep.seeds=12 --set "learning.updates=${UPDATES:-3000}" --set checkpoint.every=100)
run=$dir/run

daemons=()
end() {
  code=$?
  test $code -eq 0 || tail -n 20 "$dir"/*.log || true
  scancel --quiet --user="$(id -un)" || true
  # What is still at work ends with its job, and not with the daemons.
  for _ in $(seq 100); do
    test -n "$(squeue --noheader --states=running,completing 2>/dev/null)" || break
    sleep 0.1
  done
  kill "${daemons[@]}" 2>/dev/null || true
  kill "$(cat "$dir/munged.pid")" 2>/dev/null || true
  sleep 1
  rm -rf "$dir"
  exit $code
}
trap end EXIT

# Waits until a command succeeds, and not for ever.
until_() {
  for _ in $(seq 1200); do
    if "$@" >/dev/null 2>&1; then return; fi
    sleep 0.1
  done
  echo "never: $*"
  return 1
}

start_cluster() {
  mkdir "$dir/state" "$dir/node1" "$dir/node2"
  # Another test may run beside this one.
  ports=$((20000 + $$ % 4000 * 3))
  sed "s#DIR#$dir#g; s/HOST/$(hostname)/g; s/CPUS/$(nproc)/g
    s/PORT0/$ports/; s/PORT1/$((ports + 1))/; s/PORT2/$((ports + 2))/" \
    tests/cluster/slurm.conf >"$SLURM_CONF"
  (umask 077 && head -c 1024 /dev/urandom >"$dir/munge.key")
  munged --force --key-file="$dir/munge.key" --socket="$dir/munge.socket" \
    --pid-file="$dir/munged.pid" --log-file="$dir/munged.log" --seed-file="$dir/munged.seed"
  slurmctld -D -f "$SLURM_CONF" >"$dir/controller.log" 2>&1 & daemons+=($!)
  for node in node1 node2; do
    slurmd -D -N $node -f "$SLURM_CONF" >"$dir/$node.out.log" 2>&1 & daemons+=($!)
  done
  until_ both_nodes idle
}

both_nodes() { test "$(sinfo --noheader --format=%N:%t --Node | sort -u | grep -c ":$1")" -eq 2; }
state_of() { squeue --noheader --array --states=all --jobs="$1" --format=%T; }
is() { test "$(state_of "$1")" = "$2"; }
restarts_of() { scontrol --oneliner show job "$1" | grep -o 'Restarts=[0-9]*' | cut -d= -f2; }
restarted() { test "$(restarts_of "$1")" -ge "$2"; }
status() { "$program" status "$run" || true; }
at_work() { status | grep -q ' running'; }
on_node1() { squeue --noheader --array --nodelist=node1 --states=running --format=%i; }
node1_at_work() { test -n "$(on_node1)"; }
nobody_queued() { test -z "$(squeue --noheader)"; }

start_cluster
"$program" train "${what[@]}" --out "$dir/alone" >"$dir/alone.log" 2>&1

"$program" slurm "${what[@]}" --out "$run" --nodes 3 --cpus 1 --time 10m >"$dir/job.sh"
job=$(sbatch --parsable "$dir/job.sh")
until_ at_work

echo "worker 1 is put back into the queue"
until_ is "${job}_1" RUNNING
scontrol requeue "${job}_1"
until_ restarted "${job}_1" 1

echo "worker 2 is signalled twice"
until_ is "${job}_2" RUNNING
scancel --batch --signal=USR1 "${job}_2" & sleep 0.05
scancel --batch --signal=USR1 "${job}_2" || true
wait $!
until_ restarted "${job}_2" 1

echo "a worker comes late"
late=$(sbatch --parsable --array=9 "$dir/job.sh")

echo "a node goes down with what runs on it"
until_ node1_at_work
lost=$(on_node1 | head -n 1)
before=$(restarts_of "$lost")
scontrol update nodename=node1 state=down reason=test
until_ restarted "$lost" $((before + 1))
scontrol update nodename=node1 state=resume

until_ nobody_queued
for worker in "${job}_1" "${job}_2" "${job}_3" "${late}_9"; do
  scontrol --oneliner show job "$worker" | grep -q 'JobState=COMPLETED .*ExitCode=0:0'
  test -s "$dir/run.$worker.log"
done
"$program" status "$run" | grep -q '^24 cells: 24 done$'
diff --recursive --brief --exclude=lock "$dir/alone/cells" "$run/cells"
echo "all cells are done, with the bytes of one process"
