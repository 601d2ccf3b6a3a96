#!/bin/bash
# Runs in the guest of scripts/test-service, under its systemd: installs the packages, and does to plants what happens to
# plants. Prints "ok NAME", "not ok NAME" for each check, and "@end". What is to be done is a word of the kernel's command
# line: main, cut (until the power fails), after (the next start). Time in the guest is that of its instructions.
cd /
export LC_ALL=C PATH=/usr/sbin:/usr/bin:/sbin:/bin
exec > >(exec cat >/dev/ttyS1) 2>&1 </dev/null   # no terminal: dpkg would draw on it

check() { # NAME COMMAND..
  local name=$1
  shift
  if "$@"; then
    echo "ok $name"
  else
    echo "not ok $name: $*"
    { systemctl list-units --all --plain --no-legend 'picard@*'
      journalctl -q --no-pager -n 25 -u 'picard@*'; } 2>&1 | sed 's/^/  | /'
  fi
}
soon() { # SECONDS COMMAND..: until it succeeds
  local end=$((SECONDS + $1))
  shift
  until "$@" 2>/dev/null; do
    ((SECONDS < end)) || return 1
    sleep 0.2
  done
}
is() { [[ $1 == "$2" ]] || { echo "  | is \"$1\", not \"$2\""; return 1; }; }
not() { ! "$@"; }

property() { systemctl show --value -p "$2" "picard@$1.service"; }
is_state() { [[ $(property "$1" ActiveState) == "$2" ]]; }
has_crash() { compgen -G "/var/lib/picard/$1/records/crash-*.rec" >/dev/null; }
is_restarted() { [[ $(property "$1" NRestarts) -ge $2 ]] && is_state "$1" active; }
said() { journalctl -q --no-pager -u "picard@$1.service" -o cat | grep -q -e "$2"; }
value() { plc modbus read "$1" "${@:2}" | cut -d' ' -f2; }        # BUS TABLE ADDRESS [--type TYPE]
round() { value "$1" holding-registers 2048 --type DINT; }
scans() { value "$1" input-registers 8196 --type UDINT; }
scans_on() { # BUS: the fastest task makes scans
  local before
  before=$(scans "$1") || return 1
  [[ -n $before ]] && sleep 0.5 && [[ $(scans "$1") -gt $before ]]
}
runtime_of() { pgrep -P "$(property "$1" MainPID)"; }               # the guardian's child

plant() { # NAME PROJECT [PLC.TOML]
  mkdir -p "/etc/picard/$1"
  cp "$2" "/etc/picard/$1/"
  [[ -z ${3:-} ]] || cp "$3" "/etc/picard/$1/plc.toml"
}
drop_in() { # UNIT TEXT
  mkdir -p "/etc/systemd/system/$1.d"
  printf '%b' "$2" >"/etc/systemd/system/$1.d/test.conf"
  systemctl daemon-reload
}

# A simulated chip "plc-a" with 16 lines: make_chip, pull LINE up|down, level LINE, last_set LINE.
sim=/sys/kernel/config/gpio-sim/a
make_chip() {
  mkdir -p $sim/bank0
  echo 16 >$sim/bank0/num_lines
  echo plc-a >$sim/bank0/label
  echo 1 >$sim/live
  device=/sys/devices/platform/$(<$sim/dev_name)
  lines=$device/$(<$sim/bank0/chip_name)
  base=$(cat "$device"/gpio/*/base)
}
remove_chip() { echo 0 >$sim/live; }
pull() { echo "pull-$2" >"$lines/sim_gpio$1/pull"; }
level() { [[ $(<"$lines/sim_gpio$1/value") == "$2" ]]; }
# Who set a line last, and to what: "plc-guardian 0". The value of the line itself falls back to its pull when nobody holds it.
last_set() {
  sed -n "s/^ *\(plc-[a-z]*\)-[0-9].* gpio_value: $((base + $1)) set \([01]\)$/\1 \2/p" /sys/kernel/tracing/trace | tail -1
}
forget_sets() { echo >/sys/kernel/tracing/trace; }

# ---- install --------------------------------------------------------------------------------------
install_and_demo() {
  local began=$SECONDS
  check "install: dpkg" dpkg -i /opt/packages/picard_*.deb
  mkdir -p /etc/picard/demo
  cp /usr/share/doc/picard/examples/tank/* /etc/picard/demo/
  check "install: enable socket and plant" systemctl enable --now picard@demo.socket picard@demo.service
  check "install: the demo scans" soon 60 scans_on 127.0.0.1:502
  echo "@measured from dpkg to the demo's scans: $((SECONDS - began)) s"
  check "install: within 60 s" test $((SECONDS - began)) -le 60
  check "install: the user has the groups of devices" test "$(id -Gn picard)" = "picard dialout gpio" -o "$(id -Gn picard)" = "picard gpio dialout"
}

rights() {
  local pid
  pid=$(property demo MainPID)
  check "rights: runs as picard" is "$(stat -c %U "/proc/$pid")" picard
  check "rights: no capabilities" grep -q '^CapEff:.0000000000000000$' "/proc/$pid/status"
  check "rights: no new privileges" grep -q '^NoNewPrivs:.1$' "/proc/$pid/status"
  check "rights: memory is locked" grep -q '^VmLck:[[:space:]]*[1-9]' "/proc/$pid/status"
  check "rights: real-time priority" said demo 'real time: SCHED_FIFO priorities and locked memory'
  check "rights: a thread has SCHED_FIFO" grep -qs ' [12]$' <(cut -d' ' -f41 /proc/"$pid"/task/*/stat | sed 's/^/ /')
  local exposure
  exposure=$(systemd-analyze security --no-pager picard@demo.service | sed -n 's/.*Overall exposure level.*: \([0-9.]*\) .*/\1/p')
  echo "@measured exposure: $exposure"
  check "rights: exposure at most 3.0" awk "BEGIN { exit !(${exposure:-9} <= 3.0) }"
  check "rights: the engine is native" not said demo 'interpreter'
}

stop_and_start() {
  check "stop: ends" systemctl stop picard@demo.service
  check "stop: is no failure" is "$(property demo ActiveState) $(property demo ExecMainStatus)" "inactive 0"
  check "stop: the socket went with it" is "$(systemctl is-active picard@demo.socket)" inactive
  plc modbus read 127.0.0.1:502 input-registers 8192
  sleep 1
  check "stop: a client does not start it" is_state demo inactive
  check "start: again" systemctl start picard@demo.service
  check "start: with its socket" soon 20 scans_on 127.0.0.1:502
  check "start: served by the socket of systemd" said demo 'listening on 127.0.0.1:502'
  check "restart: takes the socket along" systemctl restart picard@demo.service
  check "restart: is served" soon 20 scans_on 127.0.0.1:502
}

two_plants() {
  plant second /opt/service/counter.st
  drop_in picard@second.socket '[Socket]\nListenStream=\nListenStream=127.0.0.1:503\n'
  check "two: starts" systemctl enable --now picard@second.socket picard@second.service
  check "two: the second is served" soon 20 scans_on 127.0.0.1:503
  check "two: the first still is" scans_on 127.0.0.1:502
  check "two: folders of their own" test -f /var/lib/picard/second/retain -a -d /var/lib/picard/demo
  systemctl disable -q --now picard@demo.socket picard@demo.service
}

bad_plants() {
  plant bad /opt/service/counter.st
  sed -i 's/Round + 1/Rounds + 1/' /etc/picard/bad/counter.st
  systemctl start picard@bad.service
  check "bad project: fails" soon 20 is_state bad failed
  sleep 4
  check "bad project: is not started again" is "$(property bad ActiveState) $(property bad NRestarts)" "failed 0"
  check "bad project: says where" said bad 'counter.st:[0-9]*:[0-9]*: error'
  systemctl start picard@nobody.service
  check "no folder: fails, and is not started again" is "$(property nobody ActiveState) $(property nobody NRestarts)" "failed 0"
  check "no folder: says so" said nobody '/etc/picard/nobody.* cannot be read'
}

late_address() {
  plant late /opt/service/counter.st
  printf '[modbus]\nlisten = "10.77.0.1:1502"\n' >/etc/picard/late/plc.toml
  check "late address: control starts without it" systemctl start picard@late.service
  check "late address: says so" soon 10 said late 'P7510'
  sleep 20
  check "late address: still runs after 20 s" is "$(property late ActiveState) $(property late NRestarts)" "active 0"
  ip address add 10.77.0.1/32 dev lo
  check "late address: is served when it is there" soon 20 scans_on 10.77.0.1:1502
  systemctl stop picard@late.service
  drop_in picard@late.socket '[Socket]\nListenStream=\nListenStream=10.77.0.2:502\n'
  rm /etc/picard/late/plc.toml
  check "late address of a socket: starts" systemctl start picard@late.socket picard@late.service
  ip address add 10.77.0.2/32 dev lo
  check "late address of a socket: is served when it is there" soon 20 scans_on 10.77.0.2:502
  systemctl stop picard@late.service
}

gpio() {
  plant panel /opt/service/panel.st /opt/service/panel.toml
  drop_in picard@panel.socket '[Socket]\nListenStream=\nListenStream=127.0.0.1:504\n'
  systemctl enable -q picard@panel.socket
  systemctl start picard@panel.service
  sleep 20
  check "late chip: is waited for" not is_state panel failed
  check "late chip: says what is missing" said panel 'error P74'
  make_chip
  check "late chip: the plant runs when it is there" soon 30 is_state panel active
  check "late chip: its group may open it" is "$(stat -c %G "/dev/$(<$sim/bank0/chip_name)")" gpio
  check "gpio: output" soon 20 level 9 1
  check "gpio: the guardian's child serves the socket of systemd" soon 20 scans_on 127.0.0.1:504
  for direction in up down up; do
    pull 0 $direction
    check "gpio: input $direction" soon 20 level 8 "$([[ $direction == up ]] && echo 1 || echo 0)"
  done

  local restarts
  restarts=$(property panel NRestarts)
  forget_sets
  kill -KILL "$(runtime_of panel)"
  check "killed runtime: is started again" soon 60 is_restarted panel $((restarts + 1))
  check "killed runtime: what led to it is saved" soon 20 has_crash panel
  check "killed runtime: the guardian made the lines safe" grep -q "plc-guardian-.* gpio_value: $((base + 9)) set 0" /sys/kernel/tracing/trace
  check "killed runtime: the lines are back" soon 20 level 9 1

  forget_sets
  kill -KILL "$(property panel MainPID)"
  check "killed guardian: is started again" soon 60 is_restarted panel $((restarts + 2))
  check "killed guardian: the runtime made the lines safe" grep -q "plc-run-.* gpio_value: $((base + 9)) set 0" /sys/kernel/tracing/trace
  check "killed guardian: the lines are back" soon 20 level 9 1
  check "killed guardian: is served again" soon 20 scans_on 127.0.0.1:504

  forget_sets
  kill -STOP "$(runtime_of panel)"
  check "hanging runtime: is started again" soon 90 is_restarted panel $((restarts + 3))
  check "hanging runtime: the guardian made the lines safe" grep -q "plc-guardian-.* gpio_value: $((base + 9)) set 0" /sys/kernel/tracing/trace
  check "hanging runtime: the lines are back" soon 20 level 9 1

  forget_sets
  check "stop: ends" systemctl stop picard@panel.service
  check "stop: the lines are safe" is "$(last_set 9)" "plc-run 0"
  check "stop: is no failure" is_state panel inactive
  remove_chip

  # With wait = true control does not wait.
  sed -i 's/^retry/wait = true\nretry/' /etc/picard/panel/plc.toml
  check "chip waited for: control starts" systemctl start picard@panel.service
  check "chip waited for: scans" soon 20 scans_on 127.0.0.1:504
  sleep 20
  make_chip
  check "chip waited for: lines when it is there" soon 20 level 9 1
  check "chip waited for: no restart" is "$(property panel NRestarts)" 0
  systemctl stop picard@panel.service
}

hang() {
  local before
  before=$(property second NRestarts)
  kill -STOP "$(property second MainPID)"
  check "hang without GPIO: the watchdog starts it again" soon 90 is_restarted second $((before + 1))
  check "hang without GPIO: is served again" soon 20 scans_on 127.0.0.1:503
  before=$(property second NRestarts)
  kill -KILL "$(property second MainPID)"
  check "kill: is started again" soon 60 is_restarted second $((before + 1))
  check "kill: is served again" soon 20 scans_on 127.0.0.1:503
  check "kill: what led to it is saved" soon 20 has_crash second
}

full_disk() {
  # A plant that ran before has its folder. What it had stored is taken away, so that there is something to store.
  plant full /opt/service/counter.st
  printf '[modbus]\nlisten = "127.0.0.1:1504"\n' >/etc/picard/full/plc.toml
  systemctl start picard@full.service
  systemctl stop picard@full.service picard@second.service
  rm /var/lib/picard/full/retain
  dd if=/dev/zero of=/var/lib/picard/filled bs=1M status=none 2>/dev/null
  dd if=/dev/zero of=/var/lib/picard/filled.too bs=512 status=none 2>/dev/null
  check "full disk: control starts, with its values" systemctl start picard@second.service
  check "full disk: scans" soon 20 scans_on 127.0.0.1:503
  check "full disk: control starts, without values" systemctl start picard@full.service
  check "full disk: scans, too" soon 20 scans_on 127.0.0.1:1504
  check "full disk: what is not kept is said" soon 20 said full P7613
  rm /var/lib/picard/filled /var/lib/picard/filled.too
  check "full disk: stores when there is space" soon 20 test -s /var/lib/picard/full/retain
  systemctl stop picard@full.service
}

clock() {
  systemctl stop picard@second.service
  date -s '1970-01-02 00:00:00' >/dev/null
  check "clock of 1970: starts" systemctl start picard@second.service
  check "clock of 1970: scans" soon 20 scans_on 127.0.0.1:503
  date -s '2026-11-27 12:00:00' >/dev/null
  check "clock set right: scans" scans_on 127.0.0.1:503
  sleep 12
  check "clock set right: no watchdog, no restart" is "$(property second ActiveState) $(property second NRestarts)" "active 0"
  date -s '2020-01-01 12:00:00' >/dev/null
  sleep 12
  check "clock set back: scans" scans_on 127.0.0.1:503
  check "clock set back: no restart" is "$(property second NRestarts)" 0
  date -s '2026-11-27 12:01:00' >/dev/null
}

upgrade_and_remove() {
  local before pid after
  before=$(round 127.0.0.1:503)
  pid=$(property second MainPID)
  check "upgrade: dpkg" dpkg -i /opt/packages/newer/picard_*.deb
  check "upgrade: the plant ran on" is "$(property second MainPID)" "$pid"
  check "upgrade: it scans" scans_on 127.0.0.1:503
  check "upgrade: restart" systemctl restart picard@second.service
  check "upgrade: served" soon 20 scans_on 127.0.0.1:503
  after=$(round 127.0.0.1:503)
  echo "@measured retained over the upgrade: $before, then $after"
  check "upgrade: retained values" test "$after" -gt "$before"
  check "downgrade: dpkg" dpkg -i /opt/packages/picard_*.deb
  check "downgrade: restart" systemctl restart picard@second.service
  check "downgrade: retained values" soon 20 test "$(round 127.0.0.1:503)" -gt "$after"
  check "remove: dpkg" dpkg -r picard
  check "remove: the plant was stopped" not pgrep -x plc-run
  check "remove: programs are gone" not test -e /usr/bin/plc-run
  check "remove: retained values are there" test -s /var/lib/picard/second/retain
  check "install again: dpkg" dpkg -i /opt/packages/picard_*.deb
  check "install again: the plant starts with its values" systemctl start picard@second.service
  check "install again: retained values" soon 20 test "$(round 127.0.0.1:503)" -gt "$after"
  check "purge: dpkg" dpkg -P picard
  check "purge: retained values are gone" not test -e /var/lib/picard/second
  check "purge: nothing is enabled" is "$(find /etc/systemd/system -name 'picard@*.s*' -type l)" ""
  check "purge: projects are there" test -f /etc/picard/second/counter.st
}

mountpoint -q /sys/kernel/config || mount -t configfs c /sys/kernel/config
mountpoint -q /sys/kernel/tracing || mount -t tracefs t /sys/kernel/tracing

all="install_and_demo rights stop_and_start two_plants bad_plants hang late_address gpio full_disk clock upgrade_and_remove"
word=$(tr ' ' '\n' </proc/cmdline | sed -n 's/^picard_test=//p')
echo "@guest $word: started after $(cut -d' ' -f1 /proc/uptime) s"
case $word in
  main)
    chosen=$(tr ' ' '\n' </proc/cmdline | sed -n 's/^picard_checks=//p' | tr , ' ')
    for group in ${chosen:-$all}; do
      $group
      echo "@group $group: $(cut -d. -f1 /proc/uptime) s"
    done
    ;;
  cut)
    # Round is printed as it grows, until the power fails.
    dpkg -i /opt/packages/picard_*.deb >/dev/null
    plant power /opt/service/counter.st
    printf '[modbus]\nlisten = "127.0.0.1:1505"\n' >/etc/picard/power/plc.toml
    check "power: starts" systemctl enable --now picard@power.service
    sync
    echo "@cut"
    while :; do echo "@round $(round 127.0.0.1:1505)"; done
    ;;
  after)
    check "power: the plant started by itself" soon 60 scans_on 127.0.0.1:1505
    check "power: with kept values" said power 'restored, stored'
    echo "@restored $(round 127.0.0.1:1505)"
    systemctl stop picard@power.service
    ;;
esac
echo "@end"
sync
sleep 1
systemctl poweroff --force --force
