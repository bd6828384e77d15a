// The user's choice of signals, length and open plots, kept in this browser.

export interface Layout {
    chosen?: readonly string[];
    /** Length of the live view, s; 0 is all. */
    span?: number;
    /** Plots that were opened and closed, by the keys of their signals. */
    open?: Readonly<Record<string, boolean>>;
}

const PREFIX = "narx-plots-";

export function layout(name?: string): Layout {
    try {
        const found = JSON.parse((name !== undefined && localStorage.getItem(PREFIX + name)) || "{}") as Layout;
        const chosen = Array.isArray(found.chosen) ? found.chosen.filter((key) => typeof key === "string") : undefined;
        const open = typeof found.open === "object" && found.open !== null ? found.open : undefined;
        return { chosen, span: typeof found.span === "number" ? found.span : undefined, open };
    } catch {
        return {};
    }
}

export function remember(name: string | undefined, layout: Layout): void {
    try {
        if (name !== undefined) {
            localStorage.setItem(PREFIX + name, JSON.stringify(layout));
        }
    } catch {
        // A browser without storage: the choice lasts as long as the panel.
    }
}
