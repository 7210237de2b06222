// GLSL that finds the numbers of a vertex in a texture.

/** Where vertex v lies in a texture of so many texels a row. */
export const VERTEX_FETCH = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
ivec2 texelOf(uint v, int width) { return ivec2(int(v) % width, int(v) / width); }
vec4 ofVertex(sampler2D shape, uint v) { return texelFetch(shape, texelOf(v, textureSize(shape, 0).x), 0); }
`;
