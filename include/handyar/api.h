/* SPDX-License-Identifier: MIT */
/* Which version this is, and the one thing that compilers say differently: what a library shows to
 * others. For C and C++. */
#ifndef HANDYAR_API_H
#define HANDYAR_API_H

#define HANDYAR_VERSION "1.0.0"

/* HANDYAR_API marks what programs may call, HANDYAR_INTERNAL the parts of a marked class that they
 * may not; what is not marked stays inside the shared library. */
#if defined(__GNUC__)
#define HANDYAR_API __attribute__((visibility("default")))
#define HANDYAR_INTERNAL __attribute__((visibility("hidden")))
#else
#define HANDYAR_API
#define HANDYAR_INTERNAL
#endif

#endif
