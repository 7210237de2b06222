// Sends what was placed to the command that waits for it, or lets people keep it as a file.
import { wordsOf } from '../../shared/start';
import type { LandmarkFile } from '../types/task';

const PAUSE = 500; // milliseconds after the last change

export type State = 'saved' | 'changed' | 'saving' | 'failed';

export class Saving {
  state: State = 'saved';
  private timer = 0;
  private sending: Promise<void> = Promise.resolve();

  /**
   * @param address where files go to; null where there is no server
   * @param content the file as it is now
   * @param changed hears of every other state, with a sentence where something went wrong
   */
  constructor(
    private readonly address: string | null,
    private readonly content: () => LandmarkFile,
    private readonly changed: (problem: string | null) => void,
  ) {
    addEventListener('beforeunload', (event) => {
      if (this.state !== 'saved') event.preventDefault();
    });
  }

  /** Something was placed or taken away. */
  touch(): void {
    this.turn('changed');
    if (this.address === null) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => void this.save(), PAUSE);
  }

  /** Sends the file now, after what is being sent; whether it has arrived. */
  async save(): Promise<boolean> {
    clearTimeout(this.timer);
    const before = this.sending;
    let arrived = false;
    this.sending = (async () => {
      await before;
      arrived = await this.send(this.address ?? '');
    })();
    await this.sending;
    return arrived;
  }

  /** Sends the file, and that this was all. */
  async finish(): Promise<boolean> {
    if (!(await this.save())) return false;
    return this.send(`${this.address}?finish`);
  }

  /** Hands the file over to the browser, which puts it where downloads are. */
  download(name: string): void {
    const url = URL.createObjectURL(new Blob([this.text()], { type: 'application/json' }));
    const link = document.createElement('a');
    [link.href, link.download] = [url, name];
    link.click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
    this.turn('saved');
  }

  private text(): string {
    return `${JSON.stringify(this.content(), null, 1)}\n`;
  }

  private async send(address: string): Promise<boolean> {
    this.turn('saving');
    try {
      const reply = await fetch(address, {
        method: 'POST',
        headers: { 'Content-Type': 'application/json' },
        body: this.text(),
      });
      if (!reply.ok) throw new Error(await reply.text());
    } catch (error) {
      const lost = error instanceof TypeError;
      this.turn(
        'failed',
        lost
          ? 'Nothing is saved any more: the command that showed this page has ended. Download what you placed.'
          : `It could not be saved: ${wordsOf(error)}`,
      );
      return false;
    }
    // What was changed meanwhile has set its own timer.
    if (this.state === 'saving') this.turn('saved');
    return true;
  }

  private turn(state: State, problem: string | null = null): void {
    this.state = state;
    this.changed(problem);
  }
}
