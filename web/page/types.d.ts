// What the page has beside its modules: uPlot, which is a script of its own before them.
import type uPlotClass from "./vendor/uPlot";
declare global {
  const uPlot: typeof uPlotClass;
  namespace uPlot {
    type Options = uPlotClass.Options;
    type Series = uPlotClass.Series;
    type AlignedData = uPlotClass.AlignedData;
  }
  type uPlot = uPlotClass;
}
export {};
