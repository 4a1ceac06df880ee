// Compresses the geometry of a glTF file with Draco, each primitive on a grid of its own: with_draco.mjs FROM TO
import { NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { draco } from '@gltf-transform/functions';
import draco3d from 'draco3dgltf';

const [, , from, to] = process.argv;
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({ 'draco3d.encoder': await draco3d.createEncoderModule() });
const document = await io.read(from);
await document.transform(draco({ method: 'edgebreaker', quantizePosition: 12 }));
await io.write(to, document);
