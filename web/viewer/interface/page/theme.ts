// Light or dark, as people chose or as their system is.
import type { Store } from '../state/store';

/** Whether the page is dark now. */
export function isDark(): boolean {
  return document.documentElement.dataset.theme === 'dark';
}

/** @param changed hears whether the page is dark, now and whenever that changes. */
export function followTheme(store: Store, changed: (dark: boolean) => void): void {
  const system = matchMedia('(prefers-color-scheme: dark)');
  let dark: boolean | null = null;
  const apply = () => {
    const { theme } = store.get();
    const now = theme === 'system' ? system.matches : theme === 'dark';
    if (now === dark) return;
    dark = now;
    document.documentElement.dataset.theme = now ? 'dark' : 'light';
    changed(now);
  };
  system.addEventListener('change', apply);
  store.subscribe(apply);
  apply();
}
