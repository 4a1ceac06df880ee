"""The Python module `hdalabaster`, wherever this Blender finds it."""
import importlib
import pathlib
import sys

HERE = pathlib.Path(__file__).parent
_folder = ""  # the preferences set it


def set_folder(folder):
    """The folder that holds `hdalabaster`; it comes before that of the installation, which comes before Python's path."""
    global _folder
    _folder = folder


def folders():
    """Where the module is looked for before Python's own path, first to last."""
    recorded = HERE / "module_folder.txt"
    named = [_folder] if _folder else []
    return named + ([recorded.read_text().strip()] if recorded.is_file() else [])


def is_ours(module):
    """False for other packages of this name."""
    return hasattr(module, "Renderer")


def forget():
    """Python imports a name again only after this."""
    for name in [one for one in sys.modules if one.split(".")[0] == "hdalabaster"]:
        del sys.modules[name]


def load():
    """The module. ImportError says where it was looked for."""
    if is_ours(sys.modules.get("hdalabaster")):
        return sys.modules["hdalabaster"]
    before = list(sys.path)
    errors = []
    for folder in [*folders(), None]:
        forget()
        sys.path[:] = ([folder] if folder else []) + before
        try:
            module = importlib.import_module("hdalabaster")
            if is_ours(module):
                return module
            errors.append(f"{folder or 'the path of Python'}: {module.__file__} is another package of this name")
        except ImportError as error:
            errors.append(f"{folder or 'the path of Python'}: {error}")
        finally:
            sys.path[:] = before
    version = f"{sys.version_info.major}.{sys.version_info.minor}"
    raise ImportError("the Python module hdalabaster was not found; the preferences of the add-on name its folder, and it must be "
                      f"built for Python {version}. Looked in " + "; ".join(errors))
