// Edges without steps, for a picture at rest: several samples a pixel cost most of a frame where
// no graphics card draws it.
import type { WebGLRenderer } from 'three';

const SAMPLES = 4;
const BYTES = 8; // of a sample: its colour and its depth

/** Where a picture is drawn until it is whole, when its edges are to be soft. */
export class SoftEdges {
  private readonly gl: WebGL2RenderingContext;
  private target: WebGLFramebuffer | null = null;
  private buffers: WebGLRenderbuffer[] = [];
  private width = 0;
  private height = 0;

  constructor(private readonly renderer: WebGLRenderer) {
    this.gl = renderer.getContext() as WebGL2RenderingContext;
  }

  get bytes(): number {
    return this.target ? SAMPLES * BYTES * this.width * this.height : 0;
  }

  /** What three.js draws on the canvas from now on goes here, until it turns to another target. */
  take(): void {
    const { gl, renderer } = this;
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    if (!this.target || width !== this.width || height !== this.height) this.make(width, height);
    renderer.state.bindFramebuffer(gl.FRAMEBUFFER, this.target);
  }

  /** Gives the canvas what was drawn here. */
  show(): void {
    const { gl, renderer, width, height } = this;
    const { state } = renderer;
    renderer.setScissorTest(false);
    state.bindFramebuffer(gl.READ_FRAMEBUFFER, this.target);
    state.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    const whole = [0, 0, width, height] as const;
    gl.blitFramebuffer(...whole, ...whole, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    state.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
  }

  /** The context was lost, and what it held with it. */
  forget(): void {
    this.target = null;
    this.buffers = [];
  }

  dispose(): void {
    const { gl } = this;
    gl.deleteFramebuffer(this.target);
    for (const buffer of this.buffers) gl.deleteRenderbuffer(buffer);
    this.forget();
  }

  private make(width: number, height: number): void {
    const { gl } = this;
    this.dispose();
    [this.width, this.height] = [width, height];
    this.target = gl.createFramebuffer();
    this.renderer.state.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    this.buffers = (
      [
        [gl.COLOR_ATTACHMENT0, gl.RGBA8],
        [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24],
      ] as const
    ).map(([attachment, format]) => {
      const buffer = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, SAMPLES, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
      return buffer;
    });
  }
}
