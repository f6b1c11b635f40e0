export { WebGLRenderer, Scene, PerspectiveCamera, BufferGeometry, BufferAttribute, ShaderMaterial, Mesh, DoubleSide, Vector3 } from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
