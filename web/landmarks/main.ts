// The page where landmarks are placed: does what the page was given to do.
import './style.css';
import { start } from './app';
import { taskOf } from './state/document';
import { followSystem } from './theme';

const root = document.querySelector<HTMLElement>('#landmarks');
if (!root) throw new Error('the page has no element #landmarks');
followSystem();
try {
  start(root, taskOf(document));
} catch (error) {
  const words = document.createElement('p');
  words.setAttribute('role', 'alert');
  words.className = 'cannot';
  words.textContent = error instanceof Error ? error.message : String(error);
  root.replaceChildren(words);
}
