// SPDX-License-Identifier: Apache-2.0
// Devices with six axes (3Dconnexion, by WebHID) and game pads: how fast they are pushed, and their buttons.

/** From -1 to 1: right, down the screen, up. */
export interface Push {
  x: number;
  y: number;
  up: number;
}

interface HidDevice extends EventTarget {
  opened: boolean;
  vendorId: number;
  productName: string;
  open(): Promise<void>;
}
interface Hid {
  requestDevice(options: { filters: { vendorId: number; usagePage?: number; usage?: number }[] }): Promise<HidDevice[]>;
  getDevices(): Promise<HidDevice[]>;
}
interface InputReport extends Event {
  reportId: number;
  data: DataView;
}

// 3Dconnexion, and Logitech who sold them before; generic desktop, multi-axis controller.
const filters = [{ vendorId: 0x256f, usagePage: 1, usage: 8 }, { vendorId: 0x046d, usagePage: 1, usage: 8 }];
const full = 350; // counts at the end of an axis
const dead = 0.08;

const hidOf = (): Hid | undefined => (navigator as Navigator & { hid?: Hid }).hid;
export const hasHid = (): boolean => hidOf() !== undefined;

/** Small pushes are fine, large ones fast; a hand at rest is none. */
export const shaped = (push: number): number => (Math.abs(push) < dead ? 0 : Math.sign(push) * ((Math.abs(push) - dead) / (1 - dead)) ** 2);

/** Report 1 of a SpaceMouse: three 16-bit counts, right, towards the user, down. */
export function pushIn(data: DataView): Push | undefined {
  if (data.byteLength < 6) return undefined;
  const axis = (k: number): number => Math.max(-1, Math.min(1, data.getInt16(2 * k, true) / full));
  return { x: shaped(axis(0)), y: shaped(axis(1)), up: shaped(-axis(2)) };
}

export class Devices {
  #push: Push = { x: 0, y: 0, up: 0 };
  #buttons = 0;
  #pressed = 0;
  #listened = 0;
  readonly #stop = new AbortController();

  /** `press`: button 0, 1, .. of any device; `came`: there is a device that `push` is to be asked of. */
  constructor(
    readonly press: (button: number) => void,
    readonly came: () => void = () => {},
  ) {
    globalThis.addEventListener?.("gamepadconnected", came, { signal: this.#stop.signal });
    void hidOf()?.getDevices().then((devices) => devices.forEach((one) => void this.#listen(one))).catch(() => {});
  }

  /** Asks the user for a device; its name. */
  async connect(): Promise<string | undefined> {
    const [device] = (await hidOf()?.requestDevice({ filters })) ?? [];
    if (device) await this.#listen(device);
    return device?.productName;
  }

  /** Whether there is anything to ask: browsers show a game pad once one of its buttons was pressed. */
  get isThere(): boolean {
    return this.#listened > 0 || [...(navigator.getGamepads?.() ?? [])].some((pad) => pad?.connected);
  }

  /** What is pushed now. */
  push(): Push {
    const sum = { ...this.#push };
    let pressed = 0; // on any of the pads
    for (const pad of navigator.getGamepads?.() ?? []) {
      if (!pad?.connected) continue;
      const axis = (k: number): number => shaped(pad.axes[k] ?? 0);
      [sum.x, sum.y, sum.up] = [sum.x + axis(0), sum.y + axis(1), sum.up - axis(3)];
      pressed |= pad.buttons.reduce((all, button, k) => all | (button.pressed ? 1 << k : 0), 0);
    }
    const before = this.#pressed;
    this.#pressed = pressed;
    this.#tell(pressed & ~before);
    return sum;
  }

  dispose(): void {
    this.#stop.abort();
  }

  async #listen(device: HidDevice): Promise<void> {
    if (!device.opened) await device.open();
    ++this.#listened;
    device.addEventListener("inputreport", (event) => {
      const { reportId, data } = event as InputReport;
      if (reportId === 1) this.#push = pushIn(data) ?? this.#push;
      if (reportId !== 3) return;
      const buttons = data.getUint8(0);
      this.#tell(buttons & ~this.#buttons);
      this.#buttons = buttons;
    }, { signal: this.#stop.signal });
    this.came();
  }

  #tell(buttons: number): void {
    for (let k = 0; k < 16; ++k) if (buttons & (1 << k)) this.press(k);
  }
}
