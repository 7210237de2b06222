// Prints, as JSON, the edges that the page draws of files: `node checks/edges.mjs FILE …`
import { readFile } from 'node:fs/promises';
import { fileURLToPath } from 'node:url';
import { createServer } from 'vite';

const server = await createServer({
  configFile: false,
  root: fileURLToPath(new URL('..', import.meta.url)),
  logLevel: 'error',
  appType: 'custom',
  server: { middlewareMode: true, ws: false, watch: null },
  optimizeDeps: { noDiscovery: true },
});
const page = async (name) => server.ssrLoadModule(`/viewer/files/${name}.ts`);
const { openFile } = await page('open');
const found = {};
for (const path of process.argv.slice(2)) {
  const bytes = await readFile(path);
  const { edges } = await openFile(path, new Uint8Array(bytes).buffer);
  found[path] = [...edges];
}
console.log(JSON.stringify(found));
await server.close();
