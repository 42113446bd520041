/* .pvol files for programs in C (pvol/pvol.h): from a path, or from bytes in memory, wherever these
 * came from. Link pvol::file, which needs zstd and xxhash. */
#ifndef PVOL_PVOL_FILE_H
#define PVOL_PVOL_FILE_H

#include "pvol/pvol.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Gives the volume the density of a file, with its bounds, its place, and its shell and micro-bounds
 * where it has them, for the next commit; the bytes may go at once. Everything in them is checked: a
 * damaged file, or one that only refers to its density, is PVOL_INVALID, with a message. The medium
 * is set as for other samples; the shell is used where pvol_set_shell wants one. */
pvol_status pvol_read_bytes(pvol_volume* volume, const void* bytes, size_t size);
pvol_status pvol_read_file(pvol_volume* volume, const char* path);

#ifdef __cplusplus
}
#endif

#endif
