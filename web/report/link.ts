// In a report: a link to what its viewer shows opens the report there, and the viewer so.
const frame = document.querySelector<HTMLIFrameElement>('iframe.viewer');

if (frame) {
  // A frame with its page inside does not know the address of the page around it.
  const tell = () =>
    frame.contentWindow?.postMessage({ elastomorph: 'address', href: location.href }, '*');
  const turn = () => {
    if (location.hash.startsWith('#view=')) frame.scrollIntoView();
  };
  addEventListener('message', ({ source, data }: MessageEvent<{ elastomorph?: string } | null>) => {
    if (source === frame.contentWindow && data?.elastomorph === 'ready') tell();
  });
  addEventListener('hashchange', () => {
    turn();
    tell();
  });
  turn();
}

export {};
