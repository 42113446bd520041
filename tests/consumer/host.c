/* A program that knows nothing of pvol and loads a plug-in that has it, twice. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>

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
    dlclose(plugin);
  }
  return 0;
}
