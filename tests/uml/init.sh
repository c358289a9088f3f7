#!/bin/sh
# First process of the user-mode-linux kernel. Its root is the host's file system, read-only; only $cansync_work/out is
# the host's own and writable.
PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
export PATH
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mountpoint -q /dev || mount -t devtmpfs devtmpfs /dev
mkdir -p /dev/pts /dev/shm
mount -t devpts devpts /dev/pts
mount -t tmpfs tmpfs /dev/shm
mount -t tmpfs tmpfs /run
mount -t tmpfs tmpfs "$cansync_work/tmp"
mount -t hostfs hostfs "$cansync_work/out" -o "$cansync_work/out"
. "$cansync_work/environment"
exec "$PYTHON" -B "$INSIDE" "$cansync_work/out"
