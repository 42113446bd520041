/* A program that loads a plug-in that has pvol, twice, and shows functions of its own by names of
 * pvol's, as one does that has another version. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>

static int calls = 0;
int pvol_commit(void* volume, const void* options) {
  (void)volume, (void)options;
  ++calls;
  return 4;
}

int main(int count, char** arguments) {
  int round;
  for (round = 0; round < 2; ++round) {
    void* plugin = count > 1 ? dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    double (*transmittance)(int);
    int (*catches)(void);
    double found, exact = exp(-0.125 * 20);
    if (plugin == NULL) {
      fprintf(stderr, "%s\n", dlerror());
      return 2;
    }
    *(void**)&transmittance = dlsym(plugin, "transmittance_of_plugin");
    *(void**)&catches = dlsym(plugin, "plugin_catches_errors");
    if (transmittance == NULL || catches == NULL) return 3;
    found = transmittance(200000);
    printf("plug-in: %.4f, exactly %.4f\n", found, exact);
    if (fabs(found - exact) > 0.003 || !catches()) return 1;
    if (calls != 0) {
      fprintf(stderr, "the plug-in called the program's pvol_commit\n");
      return 4;
    }
    dlclose(plugin);
  }
  return 0;
}
