// Draws a surface with WebGL: lit clay, its own colours or its texture, and its edges.
import { LIGHT } from '../../shared/light';
import type { Mesh } from '../geometry/mesh';

const VERTEX = /* glsl */ `#version 300 es
in vec3 position;
in vec3 normal;
in vec2 uv;
in vec4 colour;
uniform mat3 turn;
uniform vec4 frame; // where the origin is, and pixels a unit; all over half of the picture
uniform float depth;
uniform float lift;
out vec3 n;
out vec2 st;
out vec4 own;
void main() {
  vec3 q = turn * position;
  n = turn * normal;
  st = vec2(uv.x, 1.0 - uv.y);
  own = colour;
  gl_Position = vec4(frame.xy + frame.zw * q.xy, -q.z / depth - lift, 1.0);
}`;

const FRAGMENT = /* glsl */ `#version 300 es
precision highp float;
in vec3 n;
in vec2 st;
in vec4 own;
uniform sampler2D image;
uniform int looks; // 0 clay, 1 colours, 2 texture, 3 edges
uniform vec4 line;
out vec4 seen;
${LIGHT}
void main() {
  if (looks == 3) { seen = line; return; }
  vec3 m = normalize(gl_FrontFacing ? n : -n);
  if (looks == 0) {
    seen = vec4(encoded(toned(studio(vec3(0.42, 0.30, 0.24), 0.12, 0.0, 1.0, m, vec3(0, 0, 1)))), 1.0);
  } else {
    vec3 colour = looks == 1 ? own.rgb : texture(image, st).rgb;
    seen = vec4(colour * (0.8 + 0.2 * m.z), 1.0);
  }
}`;

/** How a surface is looked at, whatever the size of the picture. */
export interface SurfaceView {
  readonly turn: readonly number[]; // row by row
  /** Whether all of it is to be in the picture, as long as nobody has moved it. */
  readonly fits: boolean;
  readonly scale: number; // CSS pixels a unit
  readonly x: number; // CSS pixels from the middle of the picture to the origin
  readonly y: number;
}

export interface Looks {
  readonly clay: boolean;
  readonly edges: boolean;
}

export class Painter {
  private readonly gl: WebGL2RenderingContext;
  private readonly program: WebGLProgram;
  private readonly faces: WebGLVertexArrayObject;
  private readonly lines: WebGLVertexArrayObject;
  private readonly textures: readonly (WebGLTexture | null)[];
  private readonly depth: number;

  constructor(
    canvas: HTMLCanvasElement,
    private readonly mesh: Mesh,
    images: readonly (ImageBitmap | null)[],
  ) {
    const gl = canvas.getContext('webgl2', { antialias: true, alpha: true });
    if (!gl) throw new Error('This browser draws no WebGL 2, which surfaces need; use another one.');
    this.gl = gl;
    this.program = linked(gl);
    this.depth = 1.05 * Math.hypot(...mesh.high.map((value, i) => value - mesh.low[i]!)) || 1;
    const attributes: [string, ArrayBufferView<ArrayBuffer> | null, number, number][] = [
      ['position', mesh.positions, 3, gl.FLOAT],
      ['normal', mesh.normals, 3, gl.FLOAT],
      ['uv', mesh.uv, 2, gl.FLOAT],
      ['colour', mesh.colours, 4, gl.UNSIGNED_BYTE],
    ];
    const buffers = attributes.map(([, values]) => values && buffer(gl, gl.ARRAY_BUFFER, values));
    const array = (corners: Uint32Array<ArrayBuffer>) => {
      const made = gl.createVertexArray();
      gl.bindVertexArray(made);
      attributes.forEach(([name, , size, kind], i) => {
        const place = gl.getAttribLocation(this.program, name);
        if (place < 0 || !buffers[i]) return;
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers[i]!);
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, size, kind, kind === gl.UNSIGNED_BYTE, 0, 0);
      });
      buffer(gl, gl.ELEMENT_ARRAY_BUFFER, corners);
      return made;
    };
    this.faces = array(mesh.triangles);
    this.lines = array(mesh.edges);
    this.textures = images.map((image) => image && texture(gl, image));
  }

  /** Draws into the lower left of the canvas, so many CSS pixels wide and high. */
  draw(view: SurfaceView, width: number, height: number, ratio: number, looks: Looks): void {
    const { gl, program, mesh } = this;
    const at = (name: string) => gl.getUniformLocation(program, name);
    gl.viewport(0, 0, Math.round(width * ratio), Math.round(height * ratio));
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniformMatrix3fv(at('turn'), true, view.turn);
    const [a, b] = [2 / width, 2 / height];
    gl.uniform4f(at('frame'), a * view.x, -b * view.y, a * view.scale, b * view.scale);
    gl.uniform1f(at('depth'), this.depth);
    gl.uniform1f(at('lift'), 0);
    gl.bindVertexArray(this.faces);
    for (const { start, count, image } of mesh.parts) {
      const shown = looks.clay ? null : (this.textures[image] ?? null);
      gl.bindTexture(gl.TEXTURE_2D, shown);
      gl.uniform1i(at('looks'), shown ? 2 : mesh.colours && !looks.clay ? 1 : 0);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * start);
    }
    if (!looks.edges || mesh.edges.length === 0) return;
    gl.enable(gl.BLEND);
    // The surface stays opaque below them.
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.uniform1i(at('looks'), 3);
    gl.uniform4f(at('line'), 0.05, 0.05, 0.08, 0.32);
    gl.uniform1f(at('lift'), 1e-3);
    gl.bindVertexArray(this.lines);
    gl.drawElements(gl.LINES, mesh.edges.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.BLEND);
  }

  /** Gives the memory of the graphics card back. */
  dispose(): void {
    this.gl.getExtension('WEBGL_lose_context')?.loseContext();
  }
}

function linked(gl: WebGL2RenderingContext): WebGLProgram {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]] as const) {
    const shader = gl.createShader(kind)!;
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS))
    throw new Error(`The graphics card refuses to draw surfaces: ${gl.getProgramInfoLog(program)}`);
  return program;
}

function buffer(gl: WebGL2RenderingContext, kind: GLenum, values: ArrayBufferView<ArrayBuffer>) {
  const made = gl.createBuffer();
  gl.bindBuffer(kind, made);
  gl.bufferData(kind, values, gl.STATIC_DRAW);
  return made;
}

function texture(gl: WebGL2RenderingContext, image: ImageBitmap): WebGLTexture {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return made;
}
