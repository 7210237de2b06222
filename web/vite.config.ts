// The pages as one file each that asks the network for nothing: `npm run build` writes the viewer,
// `npm run build:landmarks` the page where landmarks are placed, as the Python package ships them.
import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

const here = (path: string) => decodeURIComponent(new URL(path, import.meta.url).pathname);

export default defineConfig(({ mode }) => {
  const landmarks = mode === 'landmarks';
  return {
    root: here(landmarks ? 'landmarks' : 'viewer'),
    plugins: [viteSingleFile({ removeViteModuleLoader: true })],
    build: {
      outDir: here(`../src/elastomorph/viewer/${landmarks ? 'landmarks_page' : 'page'}`),
      emptyOutDir: true,
      target: 'es2022',
      reportCompressedSize: false,
      modulePreload: false,
    },
  };
});
