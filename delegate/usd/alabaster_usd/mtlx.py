"""Files of MaterialX (.mtlx) that a stage names, as layers: usd-core has no reader of them. Needs the package MaterialX."""
import os

from pxr import Gf, Sdf, Usd, UsdShade

from .notes import Fault

TYPES = {"float": (Sdf.ValueTypeNames.Float, float), "integer": (Sdf.ValueTypeNames.Int, int), "boolean": (Sdf.ValueTypeNames.Bool, bool),
         "string": (Sdf.ValueTypeNames.String, str), "color3": (Sdf.ValueTypeNames.Color3f, lambda v: Gf.Vec3f(*v)),
         "color4": (Sdf.ValueTypeNames.Color4f, lambda v: Gf.Vec4f(*v)), "vector2": (Sdf.ValueTypeNames.Float2, lambda v: Gf.Vec2f(*v)),
         "vector3": (Sdf.ValueTypeNames.Float3, lambda v: Gf.Vec3f(*v)), "vector4": (Sdf.ValueTypeNames.Float4, lambda v: Gf.Vec4f(*v))}


def place_layers(stage):
    """Puts a layer in the place of each .mtlx that a used layer names, until none is left. Returns faults and the files."""
    done, faults, files = {}, [], []
    while True:
        changed = False
        for layer in stage.GetUsedLayers():
            if layer.anonymous:
                continue
            for asset in layer.GetCompositionAssetDependencies():
                if not asset.lower().endswith(".mtlx"):
                    continue
                file = Sdf.ComputeAssetPathRelativeToLayer(layer, asset)
                if file not in done:
                    done[file] = None
                    if os.path.isfile(file):
                        try:
                            done[file] = Document(file).layer()
                            files.append(os.path.realpath(file))
                        except Fault as e:
                            faults.append(e.said)
                if done[file]:
                    changed = layer.UpdateCompositionAssetDependency(asset, done[file].identifier) or changed
        if not changed:
            return faults, files, done


class Document:
    def __init__(self, file):
        try:
            import MaterialX as mx
        except ImportError:
            raise Fault("it needs the Python package MaterialX: `alabaster usd install` brings it", file) from None
        self.file, self.doc = file, mx.createDocument()
        try:
            mx.readFromXmlFile(self.doc, file, mx.FileSearchPath(os.path.dirname(file)))
            self.doc.importLibrary(library(mx))
        except Exception as e:
            raise Fault("it cannot be read: " + " ".join(str(e).split())[:300], file) from None

    def layer(self):
        """Each material holds its node graphs: connections must not leave what a reference brings."""
        layer = Sdf.Layer.CreateAnonymous(os.path.basename(self.file) + ".usda")
        layer.comment = self.file
        stage = Usd.Stage.Open(layer)
        stage.SetDefaultPrim(stage.DefinePrim("/MaterialX"))
        stage.DefinePrim("/MaterialX/Materials")
        for node in self.doc.getMaterialNodes():
            material = UsdShade.Material.Define(stage, "/MaterialX/Materials/" + node.getName())
            for given in node.getInputs():
                source = given.getConnectedNode()
                if source:
                    shader = self._node(stage, str(material.GetPath()), source)
                    output = {"surfaceshader": material.CreateSurfaceOutput, "displacementshader": material.CreateDisplacementOutput,
                              "volumeshader": material.CreateVolumeOutput}.get(given.getType())
                    if output:
                        output("mtlx").ConnectToSource(shader.CreateOutput("out", Sdf.ValueTypeNames.Token))
        return layer

    def _node(self, stage, material, node):
        graph = node.getParent()
        path = "%s/%s%s" % (material, graph.getName() + "/" if graph.getCategory() == "nodegraph" else "", node.getName())
        if stage.GetPrimAtPath(path):
            return UsdShade.Shader.Get(stage, path)
        shader = UsdShade.Shader.Define(stage, path)
        # With an input that it does not have a node has no definition; the looks tell of the input.
        definition = node.getNodeDef() or next((d for d in self.doc.getMatchingNodeDefs(node.getCategory()) if d.getType() == node.getType()), None)
        shader.CreateIdAttr(definition.getName() if definition else "ND_" + node.getCategory())
        for given in node.getInputs():
            outer = given.getInterfaceInput() or given
            source = outer.getConnectedNode()
            kind, make = TYPES.get(given.getType(), (Sdf.ValueTypeNames.Token, None))
            if source:
                name = outer.getOutputString() or "out"
                output = outer.getConnectedOutput()
                if output and output.getParent().getCategory() == "nodegraph":
                    name = output.getOutputString() or "out"
                upstream = self._node(stage, material, source)
                shader.CreateInput(given.getName(), kind).ConnectToSource(upstream.CreateOutput(name, kind))
            elif given.getType() == "filename":
                file = outer.getResolvedValueString()
                made = shader.CreateInput(given.getName(), Sdf.ValueTypeNames.Asset)
                made.Set(Sdf.AssetPath(file if os.path.isabs(file) or not file else os.path.join(os.path.dirname(self.file), file)))
                self._space(made, outer)
            elif make and outer.getValue() is not None:
                made = shader.CreateInput(given.getName(), kind)
                made.Set(make(outer.getValue()))
                if given.getType().startswith("color"):
                    self._space(made, outer)
                if outer.getUnit():
                    made.GetAttr().SetCustomDataByKey("unit", outer.getUnit())
        return shader

    @staticmethod
    def _space(made, given):
        if given.getActiveColorSpace():
            made.GetAttr().SetColorSpace(given.getActiveColorSpace())


def library(mx, held=[]):
    if not held:
        held.append(mx.createDocument())
        mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), held[0])
    return held[0]
