// The pages as one file each that asks the network for nothing: `npm run build` writes the viewer,
// `npm run build:landmarks` the page where landmarks are placed, as the Python package ships them.
import { defineConfig, type Plugin } from 'vite';
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

export default defineConfig(({ mode }) => {
  const page = mode === 'landmarks' ? mode : 'viewer';
  const { folder, ...words } = PAGES[page];
  return {
    root: here('.'),
    plugins: [filled({ page, ...words }), shaders(), viteSingleFile({ removeViteModuleLoader: true })],
    build: {
      outDir: here(`../src/elastomorph/viewer/${folder}`),
      emptyOutDir: true,
      target: 'es2022',
      reportCompressedSize: false,
      modulePreload: false,
    },
  };
});

/** Puts words into the one `index.html` of both pages, and above the viewer the licence of three.js. */
function filled(words: Readonly<Record<string, string>>): Plugin {
  let notice = '';
  const handler = (html: string) =>
    html.replaceAll(/%(\w+)%/g, (_, name: string) => ({ notice, ...words })[name]!);
  return {
    name: 'filled',
    async buildStart() {
      if (words['page'] !== 'viewer') return;
      const licence = await this.fs.readFile(here('node_modules/three/LICENSE'), { encoding: 'utf8' });
      const contains = 'The viewer of elastomorph (MIT licence). It contains parts of three.js:';
      notice = `\n<!--\n${contains}\n\n${licence.trim()}\n-->`;
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
