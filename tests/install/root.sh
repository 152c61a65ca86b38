# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# Shared by tests in a clean Debian 12, which debootstrap makes: clean_root FOLDER MIRROR skips the test (77)
# where no root can be made, else sets folder, root and log, and fills the root. FOLDER keeps the downloads and the log;
# `rm_root` removes the root.

readonly release=bookworm

skip()
{
    printf 'skipped: %s\n' "$1"
    exit 77
}

as_root()
{
    if ((EUID == 0)); then
        "$@"
    else
        sudo "$@"
    fi
}

fail()
{
    tail -n 50 "$log"
    printf '%s: %s\n' "$(basename "$0" .sh)" "$1"
    exit 1
}

# Runs a shell command in the root, as one of its users, without the environment of this machine. Mounts end with the
# command.
enter()
{
    # shellcheck disable=SC2016 # expanded by the inner shell
    as_root unshare --mount --propagation private bash -c '
        root=$1 archives=$2 user=$3
        shift 3
        mount -t proc proc "$root/proc" && mount --rbind /dev "$root/dev" && mount --rbind /sys "$root/sys" &&
            mount -t tmpfs tmpfs "$root/tmp" && chmod 1777 "$root/tmp" &&
            mount --bind "$archives" "$root/var/cache/apt/archives" &&
            exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
                chroot "$root" su -s /bin/sh "$user" -c "cd && $*"' \
        enter "$root" "$folder/archives" "$@"
}

rm_root()
{
    as_root rm -rf --one-file-system "$root"
}

# What a root needs to install packages is made once, then unpacked for each run.
clean_root()
{
    local mirror=$2 base
    if ((EUID != 0)) && ! sudo -n true 2>/dev/null; then
        skip 'making a Debian root needs root or sudo'
    fi
    PATH=$PATH:/usr/sbin:/sbin
    command -v debootstrap >/dev/null || skip 'debootstrap is not installed (apt install debootstrap)'
    mkdir -p "$1/archives"
    folder=$(cd "$1" && pwd)
    root=$folder/root log=$folder/log base=$folder/$release.tar
    : >"$log"
    rm_root
    if [[ ! -e $base ]]; then
        printf 'making a root of Debian %s\n' "$release"
        as_root debootstrap --variant=minbase "$release" "$root" "$mirror" >>"$log" 2>&1 || fail 'debootstrap failed'
        as_root tar -C "$root" --one-file-system --exclude='./var/cache/apt/archives/*.deb' -cf "$base.part" .
        as_root mv "$base.part" "$base"
        rm_root
    fi
    as_root mkdir "$root"
    as_root tar -C "$root" -xf "$base"
    # How this machine reaches the network, with the certificates of a proxy.
    as_root cp /etc/resolv.conf /etc/hosts "$root/etc/"
    if compgen -G '/usr/local/share/ca-certificates/*.crt' >/dev/null; then
        as_root mkdir -p "$root/usr/local/share/ca-certificates"
        as_root cp /usr/local/share/ca-certificates/*.crt "$root/usr/local/share/ca-certificates/"
    fi
    apt-config dump Acquire | as_root tee "$root/etc/apt/apt.conf.d/90acquire" >/dev/null
    # The root is thrown away: no file of it needs to reach the disk.
    as_root tee "$root/etc/dpkg/dpkg.cfg.d/90unsafe-io" >/dev/null <<<force-unsafe-io
}
