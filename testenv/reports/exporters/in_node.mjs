// Inputs of kinds.py by three.js and glTF-Transform: node in_node.mjs FOLDER, with both installed (npm install three @gltf-transform/core).
import fs from 'fs';
import { createRequire } from 'module';
import path from 'path';
import { pathToFileURL } from 'url';

const folder = process.argv[2];
const require = createRequire(path.join(process.cwd(), 'node_modules', 'x.js'));
const load = async (name) => import(pathToFileURL(require.resolve(name)).href);
globalThis.FileReader = class {  // three.js expects a browser's
  readAsArrayBuffer(blob) { blob.arrayBuffer().then((data) => { this.result = data; this.onloadend(); }); }
};
const THREE = await import(pathToFileURL(path.resolve('node_modules/three/build/three.module.js')).href);
const { GLTFExporter } = await import(pathToFileURL(path.resolve('node_modules/three/examples/jsm/exporters/GLTFExporter.js')).href);
const { Document, NodeIO } = await load('@gltf-transform/core');
const { KHRMaterialsTransmission, KHRMaterialsVolume, KHRONOS_EXTENSIONS } = await load('@gltf-transform/extensions');

async function three(name, ...objects) {
  const scene = new THREE.Scene();
  for (const object of objects) scene.add(object);
  const data = await new GLTFExporter().parseAsync(scene, { binary: true });
  fs.writeFileSync(path.join(folder, name), Buffer.from(data));
}

// 02: 400 groups over one geometry; each becomes a primitive that shares the vertices
for (const [name, groups] of [['02_three_one.glb', 1], ['02_three_groups.glb', 400]]) {
  const geometry = new THREE.SphereGeometry(1, 160, 120), count = geometry.index.count, size = Math.ceil(count / groups / 3) * 3;
  const materials = [];
  if (groups > 1)
    for (let i = 0; i * size < count; ++i) {
      geometry.addGroup(i * size, Math.min(size, count - i * size), i);
      materials.push(new THREE.MeshStandardMaterial({ color: 0xcccccc }));
    }
  await three(name, new THREE.Mesh(geometry, groups > 1 ? materials : new THREE.MeshStandardMaterial({ color: 0xcccccc })));
}
// 03: a mesh without a vertex, beside a ball
await three('03_three.glb', new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshStandardMaterial()), new THREE.Mesh(new THREE.SphereGeometry(1), new THREE.MeshStandardMaterial()));
// 10: a pane of physical glass with a thickness
await three('10_three.glb', new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.MeshPhysicalMaterial({ transmission: 1, thickness: 0.1, roughness: 0 })));
// 18: two cameras of one name
const cameras = [0, 1].map((i) => { const c = new THREE.PerspectiveCamera(40); c.name = 'Camera'; c.position.set(i, 0, 5 + 3 * i); return c; });
await three('18_three.glb', new THREE.Mesh(new THREE.SphereGeometry(1), new THREE.MeshStandardMaterial()), ...cameras);

function square(document, material) {
  const buffer = document.getRoot().listBuffers()[0] ?? document.createBuffer();
  const accessor = (type, values) => document.createAccessor().setType(type).setArray(values).setBuffer(buffer);
  const primitive = document.createPrimitive().setMaterial(material)
    .setAttribute('POSITION', accessor('VEC3', new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0])))
    .setAttribute('NORMAL', accessor('VEC3', new Float32Array([0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1])))
    .setIndices(accessor('SCALAR', new Uint16Array([0, 1, 2, 0, 2, 3])));
  return document.createMesh('square').addPrimitive(primitive);
}
const io = new NodeIO().registerExtensions(KHRONOS_EXTENSIONS);
{  // 17: computeTangents where all texture coordinates are equal
  const document = new Document(), plane = new THREE.PlaneGeometry(2, 2);
  plane.attributes.uv.array.fill(0.5);
  plane.computeTangents();
  const image = document.createTexture().setMimeType('image/png').setImage(fs.readFileSync(path.join(folder, '17_normal.png')));
  const mesh = square(document, document.createMaterial().setMetallicFactor(0).setNormalTexture(image)), buffer = document.getRoot().listBuffers()[0];
  const primitive = mesh.listPrimitives()[0];
  for (const [name, type, attribute] of [['POSITION', 'VEC3', 'position'], ['NORMAL', 'VEC3', 'normal'], ['TANGENT', 'VEC4', 'tangent'], ['TEXCOORD_0', 'VEC2', 'uv']])
    primitive.setAttribute(name, document.createAccessor().setType(type).setArray(plane.attributes[attribute].array).setBuffer(buffer));
  primitive.setIndices(document.createAccessor().setType('SCALAR').setArray(new Uint16Array(plane.index.array)).setBuffer(buffer));
  document.createScene().addChild(document.createNode().setMesh(mesh));
  await io.write(path.join(folder, '17_three.glb'), document);
}
{  // 03: a mesh without primitives
  const document = new Document();
  const mesh = square(document, document.createMaterial());
  document.createScene().addChild(document.createNode().setMesh(mesh)).addChild(document.createNode('empty').setMesh(document.createMesh('nothing')));
  await io.write(path.join(folder, '03_gltf_transform.gltf'), document);
}
{  // 10: KHR_materials_volume on a square
  const document = new Document();
  const glass = document.createMaterial().setRoughnessFactor(0).setMetallicFactor(0);
  glass.setExtension('KHR_materials_transmission', document.createExtension(KHRMaterialsTransmission).createTransmission().setTransmissionFactor(1));
  glass.setExtension('KHR_materials_volume', document.createExtension(KHRMaterialsVolume).createVolume().setThicknessFactor(0.1));
  document.createScene().addChild(document.createNode().setMesh(square(document, glass)));
  await io.write(path.join(folder, '10_gltf_transform.glb'), document);
}
{  // 18: two nodes of one name with cameras
  const document = new Document();
  const scene = document.createScene().addChild(document.createNode().setMesh(square(document, document.createMaterial())));
  for (const z of [5, 9])
    scene.addChild(document.createNode('Camera').setTranslation([0, 0, z]).setCamera(document.createCamera().setType('perspective').setYFov(0.6).setZNear(0.1)));
  await io.write(path.join(folder, '18_gltf_transform.glb'), document);
}
