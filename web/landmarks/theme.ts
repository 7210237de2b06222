// Light or dark: as the system is, until somebody wants the other.

const system = matchMedia('(prefers-color-scheme: dark)');

export function followSystem(): void {
  const apply = () => {
    document.documentElement.dataset['theme'] = system.matches ? 'dark' : 'light';
  };
  system.addEventListener('change', apply);
  apply();
}

export function nextTheme(): void {
  const root = document.documentElement;
  root.dataset['theme'] = root.dataset['theme'] === 'dark' ? 'light' : 'dark';
}
