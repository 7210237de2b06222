// What a page hands over: text to the clipboard, and files to where downloads are.

// Frames may not ask for the clipboard, and browsers complain of those that do.
const framed = () => window.self !== window.top;

/** Copies a text; whether it is there. */
export async function copyText(text: string): Promise<boolean> {
  if (framed()) return copyBySelecting(text);
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copyBySelecting(text);
  }
}

/** The text on the clipboard; null where the browser does not let the page read it. */
export async function pastedText(): Promise<string | null> {
  if (framed()) return null;
  try {
    return await navigator.clipboard.readText();
  } catch {
    return null;
  }
}

export function download(name: string, type: string, content: BlobPart): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement('a');
  [link.href, link.download] = [url, name];
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

function copyBySelecting(text: string): boolean {
  const before = document.activeElement;
  const field = document.createElement('textarea');
  field.value = text;
  field.style.cssText = 'position: fixed; opacity: 0';
  document.body.append(field);
  field.select();
  const copied = document.execCommand('copy');
  field.remove();
  if (before instanceof HTMLElement) before.focus();
  return copied;
}
