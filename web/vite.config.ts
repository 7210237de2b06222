// The viewer as one file that asks the network for nothing: `npm run build` writes the page that
// the Python package ships.
import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

const here = (path: string) => decodeURIComponent(new URL(path, import.meta.url).pathname);

export default defineConfig({
  root: here('viewer'),
  plugins: [viteSingleFile({ removeViteModuleLoader: true })],
  build: {
    outDir: here('../src/elastomorph/viewer/page'),
    emptyOutDir: true,
    target: 'es2022',
    reportCompressedSize: false,
    modulePreload: false,
  },
});
