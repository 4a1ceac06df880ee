"""What the reader may do: read in some folders. Landlock binds the thread that asks and those that it starts, so it comes before pxr."""
import ctypes
import os
import resource
import struct
import sys
import sysconfig

READ = (1 << 2) | (1 << 3)  # files, folders
NO_NEW_PRIVILEGES = 38


def landlock_version():
    """None: the kernel has none (before 5.13, or it is off)."""
    version = _libc().syscall(444, None, 0, 1)
    return version if version > 0 else None


def _libc():
    return ctypes.CDLL(None, use_errno=True)


def _interpreter(site):
    """What the interpreter and pxr are made of."""
    paths = sysconfig.get_paths()
    folders = [site, paths["stdlib"], paths["platstdlib"], paths["purelib"], paths["platlib"], os.path.join(sys.base_prefix, "lib"),
               os.path.dirname(os.path.abspath(__file__)), "/lib", "/lib64", "/usr/lib", "/usr/lib64", "/etc/ld.so.cache",
               "/etc/localtime", "/dev/null", "/dev/urandom", "/proc/self", "/proc/cpuinfo", "/sys/devices/system/cpu"] + sys.path
    return [f for f in folders if f and f != "/" and os.path.exists(f)]


def raise_fence(folders, site, everywhere):
    """Returns the version of Landlock, or None where files are not fenced."""
    libc = _libc()
    libc.prctl(NO_NEW_PRIVILEGES, 1, 0, 0, 0)
    version = landlock_version()
    if version is None:
        return None
    writing = sum(1 << bit for bit in range(16) if bit not in (2, 3) and
                  bit < (13 if version < 2 else 14 if version < 3 else 15 if version < 5 else 16))
    attributes = struct.pack("QQQ", writing | READ, 3 if version >= 4 else 0, 3 if version >= 6 else 0)
    attributes = attributes[:8 if version < 4 else 16 if version < 6 else 24]
    rules = libc.syscall(444, attributes, len(attributes), 0)
    if rules < 0:
        return None
    for folder in ["/"] if everywhere else _interpreter(site) + folders:
        allowed = READ if os.path.isdir(folder) else 1 << 2
        try:
            fd = os.open(folder, os.O_PATH | os.O_CLOEXEC)
        except OSError:
            continue
        libc.syscall(445, rules, 1, struct.pack("=Qi", allowed, fd), 0)
        os.close(fd)
    if libc.syscall(446, rules, 0) != 0:
        version = None
    os.close(rules)
    return version


def limit_memory(count):
    if count:
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (count if most == resource.RLIM_INFINITY else min(count, most), most))
