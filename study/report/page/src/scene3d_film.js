export function mountFilm() { throw new Error("not yet"); }
