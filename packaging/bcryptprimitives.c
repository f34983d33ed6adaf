/* bcryptprimitives.dll for wine 8, which has none: Rust's standard library asks it for random bytes. Real Windows has
 * it. */

typedef unsigned char BOOLEAN;

__declspec(dllimport) BOOLEAN __stdcall SystemFunction036(void *buffer, unsigned long size); /* RtlGenRandom */

__declspec(dllexport) int __stdcall ProcessPrng(unsigned char *buffer, unsigned long long size) {
    while (size) {
        unsigned long some = size > 0x10000000 ? 0x10000000 : (unsigned long)size;
        if (!SystemFunction036(buffer, some)) return 0;
        buffer += some;
        size -= some;
    }
    return 1;
}
