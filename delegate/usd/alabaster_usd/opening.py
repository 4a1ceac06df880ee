"""Opens a stage: layers, composition errors, variants, and what a program lists of it."""
import math
import os
import re

from pxr import Ar, Sdf, Tf, Usd, UsdGeom

from .notes import Fault

VARIANT = re.compile(r"(/[^{}]*)\{([^{}=]+)=([^{}=]*)\}")


def open_stage(asked, folders, everywhere):
    """(stage, what is told of it)."""
    file = asked["file"]
    if asked.get("search"):
        Ar.DefaultResolver.SetDefaultSearchPath(asked["search"])
    from . import mtlx
    is_library = file.lower().endswith(".mtlx")
    root = mtlx.Document(file).layer() if is_library else _layer(file)
    session = Sdf.Layer.CreateAnonymous("session.usda")
    if asked.get("session"):
        _layer(asked["session"])
        session.subLayerPaths.append(asked["session"])
    masks, cache, stage, damaged = asked.get("mask"), Usd.StageCache(), None, []
    try:
        if masks:
            stage = Usd.Stage.OpenMasked(root, session, Usd.StagePopulationMask([Sdf.Path(m) for m in masks]))
            stage.ExpandPopulationMask()
        else:
            with Usd.StageCacheContext(cache):
                stage = Usd.Stage.Open(root, session)
    except Tf.ErrorException as e:
        stage = stage or next(iter(cache.GetAllStages()), None)  # OpenUSD may have opened it without a damaged clip
        damaged = [damage_of(e, stage, file)]
        if not stage:
            raise Fault(**damaged[0]) from None
    for prim in masks or ():
        if not (Sdf.Path.IsValidPathString(prim) and stage.GetPrimAtPath(prim)):
            raise Fault("there is no prim of that path to read alone (--mask)", file, prim=prim)
    stage.SetEditTarget(stage.GetSessionLayer())
    for prim, name, choice in _variants(asked.get("variants", "")):
        _select(stage, prim, name, choice)
    more, files, held = mtlx.place_layers(stage)
    stage.held_layers = held  # as long as the stage
    if is_library:
        files.append(file)
    clips, missing = clips_of(stage, folders, everywhere)
    faults = damaged + more + faults_of(stage, folders, everywhere) + missing
    facts = facts_of(stage, faults)
    return stage, {"layers": sorted(set(layers_of(stage) + files + clips)), "faults": faults, **facts}


def plain(text):
    """(what OpenUSD says without the places in its own code, the layer, the line)."""
    quoted = re.findall(r"at line \d+ in file \S+ : '(.*?)'\s*(?=\n|$)", str(text), re.S)
    text = re.sub(r"pxrInternal\w*?__(pxrReserved__(::)?)?_?|,?@anon:0x[0-9a-f]+:session.usda@", "", " ".join(" ".join(quoted or [str(text)]).split()))
    place = re.search(r"(/[^\s@<>']+?):(\d+):\d+: ", text)
    return text[:600], place.group(1) if place else "", int(place.group(2)) if place else 0


def damage_of(error, stage, file):
    """A fault of what OpenUSD said when it opened a layer or read a value. Of a clip it may not say which."""
    text, layer, line = plain(error)
    named = re.search(r"<(/[^<>]+)>", text)
    layer = layer or (named.group(1) if named else "")
    for clip in () if layer or not stage else clips_of(stage, (), True)[0]:
        try:
            Sdf.Layer.FindOrOpen(clip)
        except Tf.ErrorException:
            layer = clip
            break
    return {"text": "it cannot be read: " + text, "file": layer or file, "prim": "", "line": line}


def _layer(file):
    if not os.path.isfile(file):
        raise Fault("there is no such file, or it may not be read", file)
    try:
        layer = Sdf.Layer.FindOrOpen(file)
    except Tf.ErrorException as e:
        raise Fault(**damage_of(e, None, file)) from None
    if not layer:
        raise Fault("it cannot be read: it is no stage of OpenUSD, or is damaged", file)
    return layer


def _variants(text):
    found = VARIANT.findall(text)
    if text and "".join("%s{%s=%s}" % f for f in found) != text.replace(" ", ""):
        raise Fault("'%s' is no choice of variants: write /prim{set=choice}" % text)
    return found


def _select(stage, prim, name, choice):
    file = stage.GetRootLayer().realPath
    at = stage.GetPrimAtPath(prim) if Sdf.Path.IsValidPathString(prim) else None
    if not at:
        raise Fault("there is no prim of that path to choose a variant of", file, prim)
    sets = at.GetVariantSets()
    if name not in sets.GetNames():
        raise Fault("it has no variant set '%s'; it has %s" % (name, ", ".join(sets.GetNames()) or "none"), file, prim)
    if choice not in sets.GetVariantSet(name).GetVariantNames():
        raise Fault("its variant set '%s' has no '%s'; it has %s" % (name, choice, ", ".join(sets.GetVariantSet(name).GetVariantNames())), file, prim)
    sets.SetSelection(name, choice)


def layers_of(stage):
    """The files that composition used, the stage's own first."""
    files = {(layer.realPath or layer.identifier).split("[")[0] for layer in stage.GetUsedLayers() if not layer.anonymous}
    return sorted(f for f in files if os.path.isabs(f))


def faults_of(stage, folders, everywhere):
    faults = []
    for error in stage.GetCompositionErrors():
        site = str(getattr(error, "rootSite", ""))
        prim = re.search(r"<([^>]+)>", site)
        text, layer, line = plain(error)
        outside = re.search(r"asset @([^@]+)@", text)
        if outside and not everywhere and os.path.isabs(outside.group(1)) and not is_within(outside.group(1), folders):
            text += " It lies outside the folder of the stage: allow it with --allow FOLDER or --allow-outside."
        faults.append({"text": text, "file": layer or stage.GetRootLayer().realPath, "prim": prim.group(1) if prim else "", "line": line})
    for file in layers_of(stage):
        if not everywhere and not is_within(file, folders):
            faults.append({"text": "It lies outside the folder of the stage: allow it with --allow FOLDER or --allow-outside.", "file": file, "prim": "", "line": 0})
    unique, seen = [], set()
    for fault in faults:
        key = (fault["file"], fault["text"])
        if key not in seen:
            seen.add(key), unique.append(fault)
    return sorted(unique, key=lambda f: (f["prim"], f["text"]))[:200]


def clips_of(stage, folders, everywhere):
    """(the files of value clips, faults): OpenUSD opens a clip when a value of it is asked, and passes over one that it cannot open."""
    files, faults = set(), []
    for prim in _prims(stage):
        for name in prim.GetMetadata("clips") if prim.HasAuthoredMetadata("clips") else ():
            for asset in Usd.ClipsAPI(prim).ComputeClipAssetPaths(name):
                file = asset.resolvedPath
                if file and (everywhere or is_within(file, folders)):
                    files.add(os.path.realpath(file.split("[")[0]))
                    continue
                text = "its value clip @%s@ %s" % (asset.path, "lies outside the folder of the stage: allow it with --allow FOLDER or --allow-outside." if file
                                                   else "does not exist")
                faults.append({"text": text, "file": stage.GetRootLayer().realPath, "prim": str(prim.GetPath()), "line": 0})
    return sorted(files), faults[:200]


def _prims(stage):
    """Also those of prototypes, once."""
    yield from stage.Traverse()
    for prototype in stage.GetPrototypes():
        yield from Usd.PrimRange(prototype)


def is_within(file, folders):
    real = os.path.realpath(file.split("[")[0])
    return any(real == f or real.startswith(f.rstrip("/") + "/") for f in folders)


def facts_of(stage, faults):
    """What a program asks of a stage."""
    def number(name, value, otherwise, least=-math.inf):
        if math.isfinite(value) and value > least:
            return value
        text = "its %s is %g: write a number%s" % (name, value, " above 0" if least == 0 else "")
        faults.append({"text": text, "file": stage.GetRootLayer().realPath, "prim": "", "line": 0})
        return otherwise

    ends = [number("startTimeCode", stage.GetStartTimeCode(), 0.0), number("endTimeCode", stage.GetEndTimeCode(), 0.0)]
    return {"range": ends if stage.HasAuthoredTimeCodeRange() else None, "varies": varies(stage),
            "timeCodesPerSecond": number("timeCodesPerSecond", stage.GetTimeCodesPerSecond(), 24.0, 0),
            "metersPerUnit": number("metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage), 0.01, 0), "up": str(UsdGeom.GetStageUpAxis(stage))}


def varies(stage):
    """Whether something may change with the time: by samples, or by value clips and splines, which no layer lists."""
    if any(layer.ListAllTimeSamples() for layer in stage.GetUsedLayers()):
        return True
    return any(prim.HasAuthoredMetadata("clips") or any(a.ValueMightBeTimeVarying() for a in prim.GetAuthoredAttributes()) for prim in _prims(stage))


def fail():
    raise Fault("memory ran out")
