// The viewer page: shows the scene that the page was given, or asks for a file.
import './style.css';
import { loadScene } from './files/scene';
import { createApp } from './interface/page/app';
import { onConsole } from './interface/page/console';
import { createStage } from './stage/stage';

const root = document.querySelector<HTMLElement>('#viewer');
if (!root) throw new Error('the page has no element #viewer');

try {
  const app = createApp(root, createStage);
  const start = async () => {
    app.busy('Loading the face…');
    try {
      const scene = await loadScene(document);
      if (scene) {
        app.show(scene);
        app.stage.show(app.store.get());
        app.stage.flush();
      }
    } catch (error) {
      app.tell(error instanceof Error ? error.message : String(error));
    }
    app.busy(null);
  };
  window.elastomorph = onConsole(app, start());
} catch (error) {
  // Without a stage there is no page: most often the browser draws no WebGL 2.
  const words = document.createElement('p');
  words.setAttribute('role', 'alert');
  words.className = 'cannot';
  words.textContent = error instanceof Error ? error.message : String(error);
  root.replaceChildren(words);
}
