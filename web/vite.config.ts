// The pages as one file each that asks the network for nothing: `npm run build` writes the viewer,
// `npm run build:landmarks` the page where landmarks are placed, as the Python package ships them.
import { zlibSync } from 'three/addons/libs/fflate.module.js';
import { build, defineConfig, type Plugin, type Rolldown } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

const here = (path: string) => decodeURIComponent(new URL(path, import.meta.url).pathname);

/** What differs in `index.html`, and the folder of the package that a page is shipped in. */
const PAGES = {
  viewer: {
    folder: 'page',
    title: 'elastomorph',
    about: 'Faces whose expressions move along curved, elastic paths',
  },
  landmarks: {
    folder: 'landmarks_page',
    title: 'Landmarks – elastomorph',
    about: 'Points of a face, placed in photographs and on meshes',
  },
};

const CONTAINS = `The viewer of elastomorph (MIT licence). It contains the decoder of Draco (the Draco Authors,
Apache License, Version 2.0: apache.org/licenses/LICENSE-2.0), that of meshoptimizer, and parts of three.js:`;
const LICENCES = ['three/LICENSE', 'meshoptimizer/LICENSE.md'];

export default defineConfig(({ mode }) => {
  const page = mode === 'landmarks' ? mode : 'viewer';
  const { folder, ...words } = PAGES[page];
  return {
    root: here('.'),
    plugins: [filled({ page, ...words }), shaders(), ownShaders(), packed(), viteSingleFile({ removeViteModuleLoader: true })],
    build: {
      outDir: here(`../src/elastomorph/viewer/${folder}`),
      emptyOutDir: true,
      target: 'es2022',
      reportCompressedSize: false,
      modulePreload: false,
    },
  };
});

/** Puts words into the one `index.html` of both pages, and above the viewer the licences of others. */
function filled(words: Readonly<Record<string, string>>): Plugin {
  let notice = '';
  const handler = (html: string) =>
    html.replaceAll(/%(\w+)%/g, (_, name: string) => ({ notice, ...words })[name]!);
  return {
    name: 'filled',
    async buildStart() {
      if (words['page'] !== 'viewer') return;
      const read = (name: string) =>
        this.fs.readFile(here(`node_modules/${name}`), { encoding: 'utf8' });
      const licences = (await Promise.all(LICENCES.map(read))).map((text) => text.trim());
      notice = `\n<!--\n${[CONTAINS, ...licences].join('\n\n')}\n-->`;
    },
    transformIndexHtml: { order: 'pre', handler },
  };
}

/** Ships shaders without what only people read: comments, indentation, ends of lines. */
function shaders(): Plugin {
  const compact = (glsl: string) => {
    const lines = glsl.replaceAll(/\/\/.*/g, '').split('\n').map((line) => line.trim());
    const own = lines.filter(Boolean).map((line) => (line.startsWith('#') ? `\n${line}\n` : line));
    return own.join(' ').trim();
  };
  return {
    name: 'shaders',
    enforce: 'pre',
    transform: (code) =>
      code.replaceAll(/(\/\* glsl \*\/ `)([^`]*)(?=`)/g, (_, before, glsl) => before + compact(glsl)),
  };
}

/** Leaves out the shaders of three.js that nothing here is drawn with: all but those of wide lines. */
function ownShaders(): Plugin {
  const drawn = /^(common|(clipping|color|colorspace|fog|logdepthbuf|premultiplied|tonemapping)_\w+)$/;
  const chunk = /^((?:var|const) (\w+) = )"(?:[^"\\]|\\.)*";$/gm;
  return {
    name: 'own-shaders',
    enforce: 'pre',
    transform: (code, id) =>
      id.endsWith('/three.module.js')
        ? code.replaceAll(chunk, (all, before, name) => (drawn.test(name) ? all : `${before}"";`))
        : null,
  };
}

/**
 * `x?packed` is what most people never need, compressed, in base64: a file, or a script with all that
 * it imports. The compressor gives the same bytes on every machine.
 */
function packed(): Plugin {
  const mark = /\?packed$/;
  return {
    name: 'packed',
    async load(id) {
      if (!mark.test(id)) return null;
      const file = id.replace(mark, '');
      const bytes = file.endsWith('.ts') ? await scriptOf(file) : await this.fs.readFile(file);
      const small = zlibSync(bytes, { level: 9, mem: 12 });
      const text = btoa(Array.from(small, (byte) => String.fromCharCode(byte)).join(''));
      return { code: `export default ${JSON.stringify(text)}`, moduleType: 'js' };
    },
  };
}

/** A script and what it imports, as one that is no module. */
async function scriptOf(entry: string): Promise<Uint8Array> {
  const rolldownOptions = { input: entry, output: { format: 'iife' as const } };
  const made = (await build({
    configFile: false,
    logLevel: 'error',
    build: { write: false, target: 'es2022', modulePreload: false, rolldownOptions },
  })) as Rolldown.RolldownOutput;
  return new TextEncoder().encode(made.output[0].code);
}
