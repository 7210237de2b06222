// The page where landmarks are placed: does what the page was given to do.
import { begin } from '../shared/start';
import { start } from './app';
import { taskOf } from './state/document';
import './style.css';
import { followSystem } from './theme';

followSystem();
begin((root) => start(root, taskOf(document)));
