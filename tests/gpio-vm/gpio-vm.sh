#!/bin/bash
# gpio-vm.sh - runs a program in a QEMU guest whose kernel has gpio-sim: GPIO chips that can be made, driven and unplugged
# through configfs and sysfs. For machines without GPIO. Pure emulation (TCG): no KVM, so timing in it means nothing.
#
#   gpio-vm.sh [options] PROGRAM [ARG...]   run PROGRAM in the guest, exit with its code
#   gpio-vm.sh [options] --prepare          only fetch the kernel and build the module
#
#   --rt             PREEMPT_RT kernel instead of the plain one
#   --add SRC[:DST]  copy one more file (ELF: with its libraries) or directory into the guest; repeatable
#   --smp N          guest CPUs (2)      --mem MIB  guest memory (512)
#   --timeout S      limit for the guest (150); exit code 124 when it is exceeded
#   --no-apt         never call apt-get; exit with 126 when something is missing
#   -v               times and the guest's kernel messages to stderr
#
# Kernel and modules are kept in $GPIO_VM_CACHE (~/.cache/picard/gpio-vm), 10 MB a kernel. In the guest: configfs at
# /sys/kernel/config with gpio-sim, an I2C bus without devices whose expanders (pcf8574 at 0x20) can be added, tracefs at /sys/kernel/tracing. Exit codes: the program's own; 124 time is up; 125 the
# guest died or gave no result; 126 this machine cannot prepare the guest (packages, rights, network), with the reason.
set -u
LC_ALL=C; export LC_ALL
CACHE=${GPIO_VM_CACHE:-${XDG_CACHE_HOME:-${HOME:-/tmp}/.cache}/picard/gpio-vm}
FLAVOUR=amd64 SMP=2 MEM=512 LIMIT=150 APT=1 VERBOSE=0 MODE=run ADD=()
die() { echo "gpio-vm: $*" >&2; exit 126; }
while [ $# -gt 0 ]; do case $1 in
  --rt) FLAVOUR=rt-amd64;; --add) ADD+=("$2"); shift;; --smp) SMP=$2; shift;; --mem) MEM=$2; shift;;
  --timeout) LIMIT=$2; shift;; --no-apt) APT=0;; -v) VERBOSE=1;; --prepare) MODE=prepare;;
  -*) die "unknown option $1";; *) break;; esac; shift; done
[ $MODE = prepare ] || [ $# -gt 0 ] || die "no program given"
T0=$(date +%s.%N)
lap() { [ $VERBOSE = 0 ] || echo "gpio-vm: $1 after $(echo "$(date +%s.%N) $T0" | awk '{printf "%.1f", $1-$2}') s" >&2; }

# ---- 1. packages -------------------------------------------------------------------------------
[ "$(uname -m)" = x86_64 ] || die "only prepared for x86_64 machines, this is $(uname -m)"
command -v dpkg-query >/dev/null || die "needs Debian's packages, and this is not Debian"
KERNEL=$CACHE/$FLAVOUR-$(sha256sum "$0" | cut -c1-12)  # made anew when this script changes
missing=()
for p in qemu-system-x86 busybox-static cpio $([ -e "$KERNEL/ok" ] || echo gcc make xz-utils); do
  [ "$(dpkg-query -W -f '${db:Status-Abbrev}' "$p" 2>/dev/null)" = "ii " ] || missing+=("$p"); done
mkdir -p "$CACHE" || die "cannot make $CACHE"
LOG=$CACHE/prepare.log
exec 9>"$CACHE/lock"; flock 9
SUDO=(); [ "$(id -u)" = 0 ] || SUDO=(sudo -n)
apt_get() {
  "${SUDO[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 "$@" >>"$LOG" 2>&1; }
if [ ${#missing[@]} -gt 0 ]; then
  [ $APT = 1 ] || die "missing, and --no-apt given: ${missing[*]}"
  apt_get update
  apt_get install -y --no-install-recommends "${missing[@]}" || die "cannot install ${missing[*]} (rights, network?), see $LOG"
fi
lap packages

# ---- 2. kernel image and modules, once for each kernel -------------------------------------------
# Debian's kernels have GPIOLIB but neither gpio-sim nor expanders: those modules are built from Debian's kernel source.
if [ ! -e "$KERNEL/ok" ]; then
  [ $APT = 1 ] || die "no kernel in $KERNEL, and --no-apt given"
  apt_get update
  IMAGE=$(apt-cache depends linux-image-$FLAVOUR | awk '$1=="Depends:"{print $2; exit}')
  [ -n "$IMAGE" ] || die "apt does not know linux-image-$FLAVOUR"
  VERSION=${IMAGE#linux-image-}; SERIES=$(echo "$VERSION" | cut -d. -f1,2)
  W=$(mktemp -d "$CACHE/build.XXXX"); mkdir "$W/img" "$W/src" "$W/mod" "$W/new"
  # The image is unpacked, not installed: no initramfs, no boot loader, little disk.
  ( cd "$W" && apt-get -qq download "$IMAGE" && dpkg-deb --fsys-tarfile "$IMAGE"*.deb |
      tar -x -C img --wildcards './boot/vmlinuz-*' '*/fs/configfs/configfs.ko*' '*/i2c/i2c-stub.ko*' \
        '*/drivers/virtio/*' '*/block/virtio_blk.ko*' '*/fs/ext4/*' '*/fs/jbd2/*' '*/fs/mbcache.ko*' '*/lib/crc16.ko*' '*/crypto/crc32c_generic.ko*' ) >>"$LOG" 2>&1 || die "cannot fetch $IMAGE, see $LOG"
  apt_get install -y --no-install-recommends "linux-headers-$VERSION" "linux-source-$SERIES" ||
    die "cannot install headers and source of $VERSION (rights, network?), see $LOG"
  have=$(dpkg-deb -f "$W/$IMAGE"*.deb Version) headers=$(dpkg-query -W -f '${Version}' "linux-headers-$VERSION")
  [ "$have" = "$headers" ] || die "the image is $have but the headers are $headers"
  tar -x -J -C "$W/src" -f "/usr/src/linux-source-$SERIES.tar.xz" --strip-components=1 --wildcards --no-wildcards-match-slash \
    '*/drivers/gpio/gpio-sim.c' '*/drivers/gpio/gpio-pcf857x.c' '*/drivers/gpio/gpiolib.h' '*/kernel/irq/irq_sim.c' || die "cannot unpack linux-source-$SERIES"
  # irq_sim.c is a built-in that Debian leaves out, and irq_to_desc() is not exported to modules.
  cp "$W/src/drivers/gpio/gpio-sim.c" "$W/mod/sim_main.c"; cp "$W/src/drivers/gpio/gpiolib.h" "$W/src/drivers/gpio/gpio-pcf857x.c" "$W/mod/"
  sed 's/handle_simple_irq(irq_to_desc(\([a-z_]*\)))/generic_handle_irq(\1)/' "$W/src/kernel/irq/irq_sim.c" >"$W/mod/irq_sim.c"
  printf 'obj-m := gpio-sim.o gpio-pcf857x.o\ngpio-sim-y := sim_main.o irq_sim.o\n' >"$W/mod/Makefile"
  make -C "/usr/src/linux-headers-$VERSION" "M=$W/mod" modules >>"$LOG" 2>&1 || die "the modules did not build, see $LOG"
  mkdir "$W/new/disk"  # what a guest with a disk needs besides (scripts/test-service)
  find "$W/img" -name '*.ko' -exec cp {} "$W/new/disk/" \;
  mv "$W"/new/disk/{configfs,i2c-stub}.ko "$W/new/"
  cp "$W"/img/boot/vmlinuz-* "$W/new/vmlinuz"
  for m in gpio-sim gpio-pcf857x; do strip -g -o "$W/new/$m.ko" "$W/mod/$m.ko"; done; echo "$VERSION" >"$W/new/ok"
  rm -rf "$KERNEL"; mv "$W/new" "$KERNEL"; rm -rf "$W"
fi
flock -u 9
lap "kernel $(cat "$KERNEL/ok") and modules"
[ $MODE != prepare ] || { echo "gpio-vm: kernel $(cat "$KERNEL/ok") in $KERNEL"; exit 0; }

# ---- 3. initramfs -------------------------------------------------------------------------------
W=$(mktemp -d "${TMPDIR:-/tmp}/gpio-vm.XXXXXX") || die "no temporary directory"
QEMU=; trap '[ -z "$QEMU" ] || kill $QEMU 2>/dev/null; rm -rf "$W"' EXIT; trap 'exit 130' INT TERM
R=$W/root
# As on Debian, /lib is /usr/lib, so that the paths that ldd gives resolve.
mkdir -p "$R"/usr/{bin,lib,lib64,lib/modules} "$R"/{proc,sys,dev,tmp,etc,run,root}
ln -s usr/bin "$R/bin"; ln -s usr/bin "$R/sbin"; ln -s usr/lib "$R/lib"; ln -s usr/lib64 "$R/lib64"
put() { # SRC DST: a file with its shared libraries, or a directory
  mkdir -p "$R/$(dirname "$2")"
  if [ -d "$1" ]; then cp -rL "$1" "$R/$2"; return; fi
  # Without debug information: the guest unpacks everything into memory, slowly.
  strip -o "$R/$2" "$1" 2>/dev/null || cp -L "$1" "$R/$2" || die "cannot copy $1"
  ldd "$1" 2>/dev/null | awk '$2=="=>" && $3 ~ /^\//{print $3} $1 ~ /^\//{print $1}' | while read -r library; do
    [ -e "$R/$library" ] || { mkdir -p "$R/$(dirname "$library")"; cp -L "$library" "$R/$library"; }; done; }
cp /bin/busybox "$R/usr/bin/busybox"
cp "$KERNEL"/*.ko "$R/usr/lib/modules/"
for a in ${ADD[@]+"${ADD[@]}"}; do s=${a%%:*}; d=${a#*:}; [ -e "$s" ] || die "--add: no $s"; put "$s" "${d#/}"; done
printf 'root:x:0:0:root:/root:/bin/sh\n' >"$R/etc/passwd"; printf 'root:x:0:\n' >"$R/etc/group"
P=$(command -v -- "$1") || die "no program $1"; shift
put "$(readlink -f "$P")" usr/bin/guest-program
{ cat <<'X'
#!/bin/busybox sh
export PATH=/usr/bin HOME=/root TMPDIR=/tmp GTEST_COLOR=no
/usr/bin/busybox --install -s /usr/bin
mount -t proc p /proc; mount -t sysfs s /sys; mount -t devtmpfs d /dev; mount -t tmpfs t /tmp
mkdir -p /dev/shm /dev/pts; mount -t tmpfs t /dev/shm; mount -t devpts d /dev/pts; ifconfig lo 127.0.0.1 up
stty -F /dev/ttyS1 raw 2>/dev/null; stty -F /dev/ttyS2 raw 2>/dev/null
insmod /lib/modules/configfs.ko; insmod /lib/modules/gpio-sim.ko || echo "gpio-sim.ko did not load"
insmod /lib/modules/i2c-stub.ko chip_addr=0x20; insmod /lib/modules/gpio-pcf857x.ko
mount -t configfs c /sys/kernel/config; mount -t tracefs t /sys/kernel/tracing
echo "guest ready after $(cut -d' ' -f1 /proc/uptime) s"
cd /tmp
X
  echo "/usr/bin/guest-program $(printf '%q ' "$@")</dev/null >/dev/ttyS1 2>&1"
  cat <<'X'
rc=$?
echo "program ended with $rc after $(cut -d' ' -f1 /proc/uptime) s"
echo "@rc=$rc" >/dev/ttyS2
stty -F /dev/ttyS1 -a >/dev/null 2>&1; sync
# isa-debug-exit: writing v to port 0xf4 ends QEMU with (v << 1 | 1)
printf "\\$(printf %o $((rc & 127)))" | dd of=/dev/port bs=1 seek=244 2>/dev/null
poweroff -f
X
} >"$R/init"; chmod +x "$R/init"
( cd "$R" && find . | cpio -o -H newc --quiet | gzip -1 ) >"$W/initrd" || die "no initramfs"
lap "initramfs ($(du -k "$W/initrd" | cut -f1) KiB)"

# ---- 4. boot and run ----------------------------------------------------------------------------
# ttyS0: kernel and init; ttyS1: the program's output; ttyS2: its exit code, which must agree with QEMU's.
# The GPIO trace events are on from boot, before there is a second CPU: enabling them patches the kernel's scheduler, and
# QEMU can miss such a patch while both CPUs run (one takes a breakpoint for ever that is no longer in memory).
timeout -k 5 "$LIMIT" qemu-system-x86_64 -accel tcg,thread=multi -cpu max -machine pc -smp "$SMP" -m "$MEM" \
  -display none -nodefaults -no-user-config -no-reboot -kernel "$KERNEL/vmlinuz" -initrd "$W/initrd" \
  -append "console=ttyS0 quiet loglevel=4 panic=-1 oops=panic nokaslr tsc=reliable mitigations=off trace_event=gpio:gpio_value" \
  -chardev "file,id=con,path=$W/console" -serial chardev:con \
  -chardev stdio,id=io,signal=off -serial chardev:io \
  -chardev "file,id=ctl,path=$W/ctl" -serial chardev:ctl \
  -device isa-debug-exit,iobase=0xf4,iosize=0x04 -monitor none </dev/null &
QEMU=$!; wait $QEMU; ended=$?; QEMU=
lap "guest ended (QEMU $ended)"
[ $VERBOSE = 0 ] || tr -d '\r' <"$W/console" | sed 's/^/guest: /' >&2
if [ $ended = 124 ] || [ $ended = 137 ]; then
  echo "gpio-vm: the guest was still running after $LIMIT s and was stopped" >&2; tail -5 "$W/console" >&2; exit 124; fi
rc=$(tr -d '\r' <"$W/ctl" 2>/dev/null | sed -n 's/^@rc=\([0-9]*\)$/\1/p')
if [ -z "$rc" ] || [ $ended != $(( (rc & 127) << 1 | 1 )) ]; then
  echo "gpio-vm: no result from the guest (QEMU $ended, marker '$rc')" >&2; tail -15 "$W/console" >&2; exit 125; fi
exit "$rc"
