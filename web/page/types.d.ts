// What the page has beside its modules: uPlot, which is a script of its own before them, and ports.
import type uPlotClass from "./vendor/uPlot";
/** A port of Web Serial, as far as the page uses one. */
export interface Port {
  readonly readable: ReadableStream<Uint8Array> | null;
  readonly writable: WritableStream<Uint8Array> | null;
  open(options: { baudRate: number; bufferSize?: number }): Promise<void>;
  close(): Promise<void>;
}
declare global {
  interface Navigator {
    readonly serial?: { requestPort(): Promise<Port> };
  }
  const uPlot: typeof uPlotClass;
  namespace uPlot {
    type Options = uPlotClass.Options;
    type Series = uPlotClass.Series;
    type AlignedData = uPlotClass.AlignedData;
  }
  type uPlot = uPlotClass;
}
