#!/bin/busybox sh
# preempt_rt.sh: what of the runtime must work on a kernel with PREEMPT_RT, in the guest that gpio-vm.sh --rt boots:
# unit tests of the runtime, the guard of the cycle, and plc-run with two tasks. Function, not timing: the guest is
# emulated. Exit code 0 when all is well.
set -u
failed=0
check() { # WHAT COMMAND..
  what=$1; shift
  if "$@"; then echo "ok: $what"; else echo "FAILED: $what"; failed=1; fi
}

# Nothing of this means anything on another kernel.
echo "kernel: $(uname -srv)"
case $(uname -v) in *PREEMPT_RT*) ;; *) echo "FAILED: this is no PREEMPT_RT kernel"; exit 1 ;; esac
check "the kernel says so itself" [ "$(cat /sys/kernel/realtime)" = 1 ]

# Less those that judge how late a thread wakes up, which means nothing in a guest that is emulated.
check "unit tests of the runtime" /srv/test_runtime --gtest_brief=1 --gtest_filter=-*ALeadIsSpentAwake*:*NobodyWaitsAwake
check "nothing but sleeping and the clock in a cycle" /srv/test_rt --gtest_brief=1

cat >/tmp/two.st <<'ST'
VAR_GLOBAL Shared : DINT; END_VAR
PROGRAM Quick VAR n : DINT; END_VAR n := n + 1; Shared := n; END_PROGRAM
PROGRAM Slow VAR seen : DINT; END_VAR seen := Shared; END_PROGRAM
CONFIGURATION C RESOURCE R ON PLC
  TASK Fast (INTERVAL := T#10ms, PRIORITY := 0);
  TASK Calm (INTERVAL := T#50ms, PRIORITY := 5);
  PROGRAM Q WITH Fast : Quick;
  PROGRAM S WITH Calm : Slow;
END_RESOURCE END_CONFIGURATION
ST
printf '[tasks.Fast]\ncpu = 1\n' >/tmp/plc.toml
/usr/bin/plc-run /tmp/two.st --config /tmp/plc.toml --modbus off --watch S.seen --stats >/tmp/out 2>&1 &
plc=$!
tries=0
until grep -q "S.seen=[1-9]" /tmp/out || [ $tries -ge 300 ]; do sleep 0.1; tries=$((tries + 1)); done
# Fields of /proc/PID/stat after the name: 38 is the real-time priority, 39 the policy, 1 being SCHED_FIFO.
cat /proc/$plc/task/*/stat | sed 's/.*) //' | cut -d' ' -f38,39 | sort -rn >/tmp/policies
check "the fast task's thread runs at SCHED_FIFO 80" grep -qx "80 1" /tmp/policies
check "the slow one's at 75" grep -qx "75 1" /tmp/policies
check "the main thread without" grep -qx "0 0" /tmp/policies
sleep 3
kill -USR1 $plc
sleep 0.5
kill -TERM $plc
wait $plc
check "plc-run ends in good order" [ $? = 0 ]
cat /tmp/out
check "real time was granted" grep -q "real time: SCHED_FIFO priorities and locked memory" /tmp/out
check "the slow task saw what the fast one wrote" grep -q "S.seen=[1-9]" /tmp/out
for task in "Fast, every 10ms" "Calm, every 50ms"; do
  check "$task: cycles, without faults, told twice" [ "$(grep -c "^$task: [1-9][0-9]* cycles, .* 0 faults$" /tmp/out)" = 2 ]
done
exit $failed
