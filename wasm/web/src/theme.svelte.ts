// Dark or light: the system's setting, or the reader's own choice, which is stored.

export type Theme = "system" | "light" | "dark";

const KEY = "narx.theme";
const system = matchMedia("(prefers-color-scheme: dark)");

let chosen = $state<Theme>(stored());
let systemIsDark = $state(system.matches);
system.addEventListener("change", () => {
    systemIsDark = system.matches;
});
apply();

/** Returns the reader's choice. */
export function theme(): Theme {
    return chosen;
}

/** Returns whether the page is dark now; pictures on a canvas depend on it. */
export function isDark(): boolean {
    return chosen === "system" ? systemIsDark : chosen === "dark";
}

export function choose(theme: Theme): void {
    chosen = theme;
    apply();
    try {
        localStorage.setItem(KEY, theme);
    } catch {
        // A browser without storage: the choice lasts until the page is closed.
    }
}

/** Colours by name and theme. */
const colours = new Map<string, string>();

/** Returns a colour of style.css for a canvas. */
export function colour(name: string): string {
    const key = `${name} ${isDark()}`;
    const known = colours.get(key);
    if (known !== undefined) {
        return known;
    }
    const probe = document.createElement("i");
    probe.style.color = `var(${name})`;
    document.body.append(probe);
    const { color } = getComputedStyle(probe);
    probe.remove();
    colours.set(key, color);
    return color;
}

function stored(): Theme {
    try {
        const theme = localStorage.getItem(KEY);
        return theme === "light" || theme === "dark" ? theme : "system";
    } catch {
        return "system";
    }
}

function apply(): void {
    document.documentElement.dataset.theme = chosen;
}
