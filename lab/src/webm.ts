// The duration of a recorded movie. Browsers write WebM as a stream, without one; players then show none and cannot seek.

/** Ids of EBML (RFC 8794) and Matroska (RFC 9559). */
const [HEAD, SEGMENT, INFO, SCALE, DURATION] = [0x1a45dfa3, 0x18538067, 0x1549a966, 0x2ad7b1, 0x4489];

interface Element {
    id: number;
    /** Bounds of its content; to the end of the file where its size is not known. */
    from: number;
    to: number;
}

function element(bytes: DataView, at: number): Element {
    const wide = Math.clz32(bytes.getUint8(at)) - 23;
    let id = 0;
    for (let k = 0; k < wide; k++) id = id * 256 + bytes.getUint8(at + k);
    const sized = at + wide;
    const long = Math.clz32(bytes.getUint8(sized)) - 23;
    let size = bytes.getUint8(sized) & (0xff >> long);
    let known = size !== 0xff >> long;
    for (let k = 1; k < long; k++) {
        const next = bytes.getUint8(sized + k);
        known ||= next !== 0xff;
        size = size * 256 + next;
    }
    const from = sized + long;
    return { id, from, to: known ? Math.min(from + size, bytes.byteLength) : bytes.byteLength };
}

/** The element with this Id among those that lie one after the other; null if there is none. */
function find(bytes: DataView, id: number, from: number, to: number): (Element & { begins: number }) | null {
    for (let at = from; at < to; ) {
        const one = element(bytes, at);
        if (one.id === id) return { ...one, begins: at };
        at = one.to;
    }
    return null;
}

/** Writes the duration into it, in s. What is no WebM of this form stays as it is. */
export async function withDuration(movie: Blob, seconds: number): Promise<Blob> {
    const buffer = await movie.arrayBuffer();
    try {
        const bytes = new DataView(buffer);
        const segment = find(bytes, SEGMENT, find(bytes, HEAD, 0, bytes.byteLength)!.to, bytes.byteLength)!;
        const info = find(bytes, INFO, segment.from, segment.to)!;
        if (find(bytes, DURATION, info.from, info.to)) return movie;
        const scale = find(bytes, SCALE, info.from, info.to);
        let nanoseconds = 0;
        for (let at = scale?.from ?? 0; at < (scale?.to ?? 0); at++) nanoseconds = nanoseconds * 256 + bytes.getUint8(at);
        const length = info.to - info.from;
        const inserted = new DataView(new ArrayBuffer(12 + 11));
        inserted.setUint32(0, INFO);
        inserted.setBigUint64(4, (1n << 56n) + BigInt(length + 11));
        inserted.setUint16(12, DURATION);
        inserted.setUint8(14, 0x88);
        inserted.setFloat64(15, (1e9 * seconds) / (nanoseconds || 1e6));
        // Where it is now, only a segment of known size would have to be longer.
        if (segment.to !== bytes.byteLength) return movie;
        const parts = [buffer.slice(0, info.begins), inserted.buffer, buffer.slice(info.from)];
        return new Blob(parts as ArrayBuffer[], { type: movie.type });
    } catch {
        return movie;
    }
}
