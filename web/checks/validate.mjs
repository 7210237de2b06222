// Runs the Khronos glTF validator on files: node checks/validate.mjs FILE…
// Prints every issue; ends with 1 if there is an error or a warning, with 2 if nothing was checked.
import { readFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import { validateBytes } from 'gltf-validator';

const SEVERITIES = ['error', 'warning', 'information', 'hint'];

async function issuesOf(path) {
  const report = await validateBytes(new Uint8Array(await readFile(path)), {
    uri: basename(path),
    maxIssues: 0,
    writeTimestamp: false,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(join(dirname(path), decodeURIComponent(uri)))),
  });
  return report.issues;
}

const paths = process.argv.slice(2);
if (paths.length === 0) {
  console.error('usage: node checks/validate.mjs FILE…');
  process.exit(2);
}
let bad = false;
for (const path of paths) {
  const issues = await issuesOf(path);
  for (const { severity, code, message, pointer } of issues.messages) {
    console.log(`${path}: ${SEVERITIES[severity]} ${code} at ${pointer ?? 'the file'}: ${message}`);
  }
  const { numErrors, numWarnings, numInfos, numHints } = issues;
  console.log(
    `${path}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`,
  );
  bad ||= numErrors + numWarnings > 0;
}
process.exit(bad ? 1 : 0);
