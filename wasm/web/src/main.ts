import "./style.css";
import { mount } from "svelte";
import App from "./App.svelte";

mount(App, { target: document.body });

/** Time until the service worker loads every file, ms: what the user waits for comes first. */
const LATER = 8000;

// Without a network the page works from the browser's storage. The development server stores nothing.
if (import.meta.env.PROD && "serviceWorker" in navigator) {
    setTimeout(() => void navigator.serviceWorker.register("./service-worker.js").catch(() => undefined), LATER);
}
