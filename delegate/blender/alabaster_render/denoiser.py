"""Open Image Denoise for final frames. The renderer finds it; the preferences and $ALABASTER_OIDN direct where."""
import os

VARIABLE = "ALABASTER_OIDN"
_given = os.environ.get(VARIABLE, "")


def set_folder(folder):
    """The preferences' folder; "" leaves the search to the environment that Blender was started in."""
    os.environ.pop(VARIABLE, None)
    if folder or _given:
        os.environ[VARIABLE] = folder or _given


def is_missing(error):
    return any(f"Open Image Denoise 2 {what}" in str(error) for what in ("cannot be used", "was not found"))
