// The script of reports, which has no page of its own: `npm run build:report` writes it beside their
// templates.
import { defineConfig } from 'vite';

const here = (path: string) => decodeURIComponent(new URL(path, import.meta.url).pathname);

export default defineConfig({
  root: here('.'),
  build: {
    outDir: here('../../src/elastomorph/report/templates'),
    emptyOutDir: false,
    target: 'es2022',
    reportCompressedSize: false,
    lib: { entry: here('copy.ts'), formats: ['iife'], name: 'copying', fileName: () => 'copy.js' },
  },
});
