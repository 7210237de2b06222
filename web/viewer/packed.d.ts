// Imports that the build stores compressed: see vite.config.ts.
declare module '*?packed' {
  const text: string;
  export default text;
}
