export const controlTests = {};
