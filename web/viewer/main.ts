// The viewer page: shows the scene that the page was given, or asks for a file.
import { begin, wordsOf } from '../shared/start';
import { loadScene } from './files/scene';
import { createApp } from './interface/page/app';
import { onConsole } from './interface/page/console';
import { createStage } from './stage/stage';
import './style.css';

// Without a stage there is no page: most often the browser draws no WebGL 2.
begin((root) => {
  const app = createApp(root, createStage);
  const show = async () => {
    app.busy('Loading the face…');
    try {
      const scene = await loadScene(document);
      if (scene) {
        await app.show(scene);
        app.stage.show(app.store.get());
        app.stage.flush();
      }
    } catch (error) {
      app.tell(wordsOf(error));
    }
    app.busy(null);
  };
  window.elastomorph = onConsole(app, show());
});
