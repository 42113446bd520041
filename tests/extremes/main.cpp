// Prints the page of extremes.
#include <iostream>

#include "extremes/extremes.h"

int main() { std::cout << pvol::extremes::page(); }
