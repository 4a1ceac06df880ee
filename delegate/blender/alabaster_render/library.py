"""The Python module `alabaster`, wherever this Blender finds it."""
import importlib
import pathlib
import sys

HERE = pathlib.Path(__file__).parent
_folder = ""  # that the preferences name


def set_folder(folder):
    """The folder that holds `alabaster`; empty: Python's path, then the folder that the add-on was installed with."""
    global _folder
    _folder = folder


def folders():
    """Where the module is looked for besides Python's own path, first to last."""
    recorded = HERE / "module_folder.txt"
    named = [_folder] if _folder else []
    return named + ([recorded.read_text().strip()] if recorded.is_file() else [])


def load():
    """The module. ImportError says where it was looked for."""
    if "alabaster" in sys.modules:
        return sys.modules["alabaster"]
    before = list(sys.path)
    errors = []
    for folder in ([] if _folder else [None]) + folders():
        sys.path[:] = ([folder] if folder else []) + before
        try:
            return importlib.import_module("alabaster")
        except ImportError as error:
            errors.append(f"{folder or 'the path of Python'}: {error}")
        finally:
            sys.path[:] = before
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    raise ImportError("the Python module alabaster was not found; the preferences of the add-on name its folder, and it must be "
                      f"built for Python {version}. Looked in " + "; ".join(errors))
