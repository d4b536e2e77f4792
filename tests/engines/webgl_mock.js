// A WebGL 2 context that draws nothing and remembers what decides about a draw: culling, depth state, framebuffer.
export class WebGLMock {
  culling = false;
  cullsFronts = false;
  frontIsClockwise = false;
  depthTest = false;
  depthWrite = true;
  framebuffer = null;
  onDraw = () => {};

  context() {
    return new Proxy(this.#functions(), {
      get: (functions, name) => {
        if (name in functions) return functions[name];
        if (/^[A-Z][A-Z0-9_]*$/.test(name)) return this.#constant(name);
        if (/^(create|get)/.test(name)) return () => ({});
        return () => {};
      },
    });
  }

  #constants = new Map();
  #constant(name) {
    if (!this.#constants.has(name)) this.#constants.set(name, 1000 + this.#constants.size);
    return this.#constants.get(name);
  }

  #functions() {
    const is = (value, name) => value === this.#constant(name);
    const capability = (on) => (which) => {
      if (is(which, 'CULL_FACE')) this.culling = on;
      if (is(which, 'DEPTH_TEST')) this.depthTest = on;
    };
    const parameter = (which) => {
      if (is(which, 'VERSION')) return 'WebGL 2.0';
      if (is(which, 'SHADING_LANGUAGE_VERSION')) return 'WebGL GLSL ES 3.00';
      if (is(which, 'SCISSOR_BOX') || is(which, 'VIEWPORT')) return [0, 0, 64, 64];
      return 16;
    };
    const draw = () => this.onDraw(this);
    return {
      canvas: { width: 64, height: 64, style: {}, addEventListener() {}, removeEventListener() {} },
      drawingBufferWidth: 64,
      drawingBufferHeight: 64,
      drawingBufferColorSpace: 'srgb',
      enable: capability(true),
      disable: capability(false),
      depthMask: (write) => (this.depthWrite = write),
      frontFace: (winding) => (this.frontIsClockwise = is(winding, 'CW')),
      cullFace: (side) => (this.cullsFronts = is(side, 'FRONT')),
      bindFramebuffer: (_, framebuffer) => (this.framebuffer = framebuffer),
      drawArrays: draw,
      drawElements: draw,
      getParameter: parameter,
      getExtension: () => null,
      getSupportedExtensions: () => [],
      getContextAttributes: () => ({ alpha: true, depth: true, stencil: false, antialias: false }),
      getShaderPrecisionFormat: () => ({ precision: 23, rangeMin: 127, rangeMax: 127 }),
      getShaderInfoLog: () => '',
      getProgramInfoLog: () => '',
      getShaderParameter: () => true,
      getProgramParameter: (_, which) => (is(which, 'LINK_STATUS') ? true : 0),
      getError: () => 0,
      isContextLost: () => false,
      checkFramebufferStatus: () => this.#constant('FRAMEBUFFER_COMPLETE'),
    };
  }

  // What is drawn where no object is mirrored: back faces, front faces or all. `flipped`: the picture is upside down.
  faces(flipped = false) {
    if (!this.culling) return 'a';
    return (this.frontIsClockwise === flipped) === this.cullsFronts ? 'b' : 'f';
  }
}
