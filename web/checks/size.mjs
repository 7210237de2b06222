// Prints, as JSON, the bytes of modules bundled and minified: `node checks/size.mjs MODULE …`
import { build } from 'vite';

const bytes = {};
for (const entry of process.argv.slice(2)) {
  const { output } = await build({
    configFile: false,
    logLevel: 'error',
    build: {
      write: false,
      target: 'es2022',
      minify: true,
      lib: { entry, formats: ['es'] },
      rolldownOptions: { output: { minify: true } },
    },
  }).then((built) => built.at(0));
  bytes[entry] = output.reduce((sum, { code }) => sum + Buffer.byteLength(code), 0);
}
console.log(JSON.stringify(bytes));
