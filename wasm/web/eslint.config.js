import svelte from "eslint-plugin-svelte";
import ts from "typescript-eslint";

export default ts.config(
    { ignores: ["dist"] },
    ...ts.configs.recommended,
    ...svelte.configs.recommended,
    { files: ["**/*.svelte", "**/*.svelte.ts"], languageOptions: { parserOptions: { parser: ts.parser } } },
    {
        rules: {
            // TypeScript finds what is not defined.
            "no-undef": "off",
            "@typescript-eslint/no-unused-vars": ["error", { argsIgnorePattern: "^_", varsIgnorePattern: "^_" }],
            // The page's addresses are hashes, which no router resolves.
            "svelte/no-navigation-without-resolve": "off",
            // svelte-check judges them.
            "svelte/no-unused-svelte-ignore": "off",
            // Maps that are replaced, never changed, need no reactive ones.
            "svelte/prefer-svelte-reactivity": "off",
            // Properties that can be bound are declared together with others.
            "prefer-const": ["error", { destructuring: "all" }],
            eqeqeq: "error",
        },
    },
);
