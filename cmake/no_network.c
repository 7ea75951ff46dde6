/* What HDF5's driver for files in the network calls of libcurl and libcrypto. limber opens no such file, and without these two a
   start of the program loads 33 libraries less. No answer: the driver says that it cannot open the file. */
#define NO_ANSWER(name) void *name(void) { return 0; }
NO_ANSWER(EVP_sha256)
NO_ANSWER(HMAC)
NO_ANSWER(SHA256)
NO_ANSWER(curl_easy_cleanup)
NO_ANSWER(curl_easy_init)
NO_ANSWER(curl_easy_perform)
NO_ANSWER(curl_easy_setopt)
NO_ANSWER(curl_global_cleanup)
NO_ANSWER(curl_global_init)
NO_ANSWER(curl_slist_append)
NO_ANSWER(curl_slist_free_all)
