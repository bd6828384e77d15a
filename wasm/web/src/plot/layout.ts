// The user's choice of signals and length of a plot, kept in this browser.

export interface Layout {
    chosen?: readonly string[];
    /** Length of the live view, s; 0 is all. */
    span?: number;
}

const PREFIX = "narx-plots-";

export function layout(name?: string): Layout {
    try {
        const found = JSON.parse((name !== undefined && localStorage.getItem(PREFIX + name)) || "{}") as Layout;
        const chosen = Array.isArray(found.chosen) ? found.chosen.filter((key) => typeof key === "string") : undefined;
        return { chosen, span: typeof found.span === "number" ? found.span : undefined };
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
