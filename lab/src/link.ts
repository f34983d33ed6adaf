// The text of a link: compressed (deflate, RFC 1951), in letters of addresses (base64url, RFC 4648).

export async function packed(text: string): Promise<string> {
    if (!("CompressionStream" in globalThis)) return encodeURIComponent(text);
    const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    return btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** Of a text with not more letters than `most`: a few bytes can stand for very many. Earlier links are not compressed. */
export async function unpacked(link: string, most: number): Promise<string> {
    if (/^(%7B|\{)/i.test(link)) return decodeURIComponent(link);
    const bytes = Uint8Array.from(atob(link.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
    const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).pipeThrough(new TextDecoderStream()).getReader();
    let text = "";
    for (let part = await reader.read(); !part.done && text.length <= most; part = await reader.read()) text += part.value;
    void reader.cancel();
    return text;
}
