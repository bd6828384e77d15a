// WebAssembly modules, each compiled once for the page and all of its workers.

import core from "narx/core_bg.wasm?url";
import full from "narx/full_bg.wasm?url";
import narx from "narx/narx_bg.wasm?url";

const ADDRESSES = { narx, core, full };
export type ModuleName = keyof typeof ADDRESSES;

declare global {
    /** Modules whose loading index.html has begun, before this script was loaded. */
    var begun: Partial<Record<ModuleName, Promise<WebAssembly.Module>>> | undefined;
}

const compiled: Partial<Record<ModuleName, Promise<WebAssembly.Module>>> = { ...globalThis.begun };

/** Loads and compiles a module. */
export function module(name: ModuleName): Promise<WebAssembly.Module> {
    const found = (compiled[name] ??= WebAssembly.compileStreaming(fetch(ADDRESSES[name])));
    return found.catch((error: Error) => {
        // The next attempt loads it again.
        compiled[name] = undefined;
        throw new Error(`The module "${name}" could not be loaded: ${error.message}`);
    });
}
