!> C interfaces of SuiteSparse KLU, the sparse LU factorisation. Indices count from zero. Floor: base. Source: Davis and Palamadai
!> Natarajan, ACM TOMS 37 (2010), Algorithm 907.
module limber_base_klu
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int, c_ptr, c_funptr, c_size_t, c_null_ptr, c_null_funptr
   implicit none
   private
   public :: klu_common_type, klu_defaults, klu_analyze, klu_factor, klu_refactor, klu_solve, klu_rgrowth, klu_free_symbolic, &
      & klu_free_numeric, klu_z_factor, klu_z_refactor, klu_z_rgrowth, klu_z_solve, klu_z_free_numeric

   !> klu_common: parameters and statistics
   type, bind(c) :: klu_common_type
      real(c_double) :: tol = 0, memgrow = 0, initmem_amd = 0, initmem = 0, maxwork = 0
      integer(c_int) :: btf = 0, ordering = 0, scale = 0
      type(c_funptr) :: user_order = c_null_funptr
      type(c_ptr) :: user_data = c_null_ptr
      integer(c_int) :: halt_if_singular = 0, status = 0, nrealloc = 0, structural_rank = 0, numerical_rank = 0, &
         & singular_col = 0, noffdiag = 0
      real(c_double) :: flops = 0, rcond = 0, condest = 0, rgrowth = 0, work = 0
      integer(c_size_t) :: memusage = 0, mempeak = 0
   end type klu_common_type

   interface

      !> Default parameters
      integer(c_int) function klu_defaults(common) bind(c)
         import :: c_int, klu_common_type
         type(klu_common_type), intent(inout) :: common
      end function klu_defaults

      !> Ordering and pattern of the factors
      type(c_ptr) function klu_analyze(n, ap, ai, common) bind(c)
         import :: c_ptr, c_int, klu_common_type
         integer(c_int), value :: n
         integer(c_int), intent(in) :: ap(*), ai(*)
         type(klu_common_type), intent(inout) :: common
      end function klu_analyze

      !> Factors with a search for pivots
      type(c_ptr) function klu_factor(ap, ai, ax, symbolic, common) bind(c)
         import :: c_ptr, c_int, c_double, klu_common_type
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*)
         type(c_ptr), value :: symbolic
         type(klu_common_type), intent(inout) :: common
      end function klu_factor

      !> Factors of other values with the pivots of the last search
      integer(c_int) function klu_refactor(ap, ai, ax, symbolic, numeric, common) bind(c)
         import :: c_ptr, c_int, c_double, klu_common_type
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*)
         type(c_ptr), value :: symbolic, numeric
         type(klu_common_type), intent(inout) :: common
      end function klu_refactor

      !> Reciprocal pivot growth into common%rgrowth: small where the pivots have become unfit
      integer(c_int) function klu_rgrowth(ap, ai, ax, symbolic, numeric, common) bind(c)
         import :: c_ptr, c_int, c_double, klu_common_type
         integer(c_int), intent(in) :: ap(*), ai(*)
         real(c_double), intent(in) :: ax(*)
         type(c_ptr), value :: symbolic, numeric
         type(klu_common_type), intent(inout) :: common
      end function klu_rgrowth

      !> Solution with the factors
      integer(c_int) function klu_solve(symbolic, numeric, ldim, nrhs, b, common) bind(c)
         import :: c_ptr, c_int, c_double, klu_common_type
         type(c_ptr), value :: symbolic, numeric
         integer(c_int), value :: ldim, nrhs
         real(c_double), intent(inout) :: b(*)
         type(klu_common_type), intent(inout) :: common
      end function klu_solve

      !> Gives the ordering back
      integer(c_int) function klu_free_symbolic(symbolic, common) bind(c)
         import :: c_ptr, c_int, klu_common_type
         type(c_ptr), intent(inout) :: symbolic
         type(klu_common_type), intent(inout) :: common
      end function klu_free_symbolic

      !> Gives the factors back
      integer(c_int) function klu_free_numeric(numeric, common) bind(c)
         import :: c_ptr, c_int, klu_common_type
         type(c_ptr), intent(inout) :: numeric
         type(klu_common_type), intent(inout) :: common
      end function klu_free_numeric

      !> The same for complex values
      type(c_ptr) function klu_z_factor(ap, ai, ax, symbolic, common) bind(c)
         import :: c_ptr, c_int, c_double_complex, klu_common_type
         integer(c_int), intent(in) :: ap(*), ai(*)
         complex(c_double_complex), intent(in) :: ax(*)
         type(c_ptr), value :: symbolic
         type(klu_common_type), intent(inout) :: common
      end function klu_z_factor

      !> The same for complex values
      integer(c_int) function klu_z_refactor(ap, ai, ax, symbolic, numeric, common) bind(c)
         import :: c_ptr, c_int, c_double_complex, klu_common_type
         integer(c_int), intent(in) :: ap(*), ai(*)
         complex(c_double_complex), intent(in) :: ax(*)
         type(c_ptr), value :: symbolic, numeric
         type(klu_common_type), intent(inout) :: common
      end function klu_z_refactor

      !> The same for complex values
      integer(c_int) function klu_z_rgrowth(ap, ai, ax, symbolic, numeric, common) bind(c)
         import :: c_ptr, c_int, c_double_complex, klu_common_type
         integer(c_int), intent(in) :: ap(*), ai(*)
         complex(c_double_complex), intent(in) :: ax(*)
         type(c_ptr), value :: symbolic, numeric
         type(klu_common_type), intent(inout) :: common
      end function klu_z_rgrowth

      !> The same for complex values
      integer(c_int) function klu_z_solve(symbolic, numeric, ldim, nrhs, b, common) bind(c)
         import :: c_ptr, c_int, c_double_complex, klu_common_type
         type(c_ptr), value :: symbolic, numeric
         integer(c_int), value :: ldim, nrhs
         complex(c_double_complex), intent(inout) :: b(*)
         type(klu_common_type), intent(inout) :: common
      end function klu_z_solve

      !> The same for complex values
      integer(c_int) function klu_z_free_numeric(numeric, common) bind(c)
         import :: c_ptr, c_int, klu_common_type
         type(c_ptr), intent(inout) :: numeric
         type(klu_common_type), intent(inout) :: common
      end function klu_z_free_numeric

   end interface

end module limber_base_klu
