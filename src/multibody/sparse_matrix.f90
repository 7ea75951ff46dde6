!> Sparse matrix with a pattern that is analysed once, and its LU factors. The factors come from KLU, or, up to some dozens of
!> unknowns, from `limber_multibody_small_sparse_lu` at half the cost. The pivots of one search serve until they become unfit for
!> the values; a matrix of a dozen unknowns is factored five times faster so than by a dense LAPACK call. One of a few unknowns is
!> eliminated here on the spot, with scaled partial pivoting. Floor: multibody.
module limber_multibody_sparse_matrix
   use, intrinsic :: iso_c_binding, only: c_int, c_ptr, c_null_ptr, c_associated
   use limber_base_kinds, only: wp
   use limber_base_snapshot, only: snapshot_type
   use limber_base_klu, only: klu_common_type, klu_defaults, klu_analyze, klu_factor, klu_refactor, klu_solve, klu_rgrowth, &
      & klu_free_symbolic, klu_free_numeric, klu_z_factor, klu_z_refactor, &
      & klu_z_rgrowth, klu_z_solve, klu_z_free_numeric
   use limber_multibody_small_sparse_lu, only: small_lu_type
   implicit none
   private
   public :: sparse_type

   !> Reciprocal pivot growth below which new pivots are sought; above the other it is looked at after so many factorisations only
   real(wp), parameter :: least_growth = 1.0e-5_wp, good_growth = 1.0e-3_wp
   integer, parameter :: seldom = 8
   !> Most unknowns of a matrix that is eliminated on the spot
   integer, parameter :: few = 6
   !> Most unknowns of one that KLU is not needed for
   integer, parameter :: some = 40

   !> A square matrix by columns. `mark` all entries, `analyse`, then fill `values` through `place` and factor.
   type :: sparse_type
      !> Number of unknowns
      integer :: n = 0
      !> Values of the entries (entries); zero where the pattern has a place that is not filled
      real(wp), allocatable :: values(:)
      !> The same of a complex matrix of the same pattern (entries); not allocated unless asked for
      complex(wp), allocatable :: complex_values(:)
      !> Counts of factorisations, and of searches for pivots among them
      integer :: factorisations = 0, searches = 0
      !> Entries marked so far, [row, column] (2, count)
      integer, allocatable, private :: marks(:, :)
      integer, private :: count = 0
      !> Factors of a matrix of few unknowns: rows in the order of the pivots, reciprocal pivots; that order, and the place of each
      !> entry in the square (entries)
      real(wp), private :: dense(few, few) = 0.0_wp
      integer, private :: pivots(few) = 0
      integer, allocatable, private :: square(:)
      !> Pivots and factors of one of some dozens: of the real and of the complex values
      type(small_lu_type), private :: own, complex_own
      !> First entry of each column (n + 1) and row of each entry, from zero
      integer(c_int), allocatable, private :: first(:), row(:)
      type(klu_common_type), private :: common
      !> Values for which the pivots were sought (entries), not of a matrix of few unknowns
      real(wp), allocatable, private :: searched(:)
      complex(wp), allocatable, private :: complex_searched(:)
      !> Whether the factors are of later values: real and complex ones
      logical, private :: renewed(2) = .false.
      !> Factorisations until the growth of the pivots is looked at again: real and complex ones
      integer, private :: unseen(2) = 0
      type(c_ptr), private :: symbolic = c_null_ptr, numeric = c_null_ptr, complex_numeric = c_null_ptr
   contains
      procedure :: mark, analyse, place, holds, follow_pivots, factor, solve, factor_complex, solve_complex
      final :: release
      procedure :: exchange => exchange_sparse
      !> Gives the factors and their pivots back: the next ones depend on nothing before
      procedure :: release_factors
   end type sparse_type

contains

   !> Takes note of an entry of the pattern; twice does no harm.
   pure subroutine mark(self, row, column)
      class(sparse_type), intent(inout) :: self
      integer, intent(in) :: row, column
      integer, allocatable :: longer(:, :)
      if (.not. allocated(self%marks)) then
         allocate (self%marks(2, 64))
         self%count = 0
      end if
      if (self%count == size(self%marks, 2)) then
         allocate (longer(2, 2*self%count))
         longer(:, :self%count) = self%marks
         call move_alloc(longer, self%marks)
      end if
      self%count = self%count + 1
      self%marks(:, self%count) = [row, column]
   end subroutine mark

   !> Turns the marks into a pattern of n unknowns, the diagonal included. Factors of an earlier pattern are given back.
   subroutine analyse(self, n)
      class(sparse_type), intent(inout) :: self
      integer, intent(in) :: n
      integer, allocatable :: start(:), sorted(:)
      integer :: i, k, column, kept, begin
      call release(self)
      if (.not. allocated(self%marks)) self%count = 0
      do i = 1, n
         call self%mark(i, i)
      end do
      allocate (start(n + 1), sorted(self%count), self%first(n + 1))
      start = 0
      do i = 1, self%count
         start(self%marks(2, i) + 1) = start(self%marks(2, i) + 1) + 1
      end do
      start(1) = 1
      do column = 1, n
         start(column + 1) = start(column + 1) + start(column)
      end do
      do i = 1, self%count
         column = self%marks(2, i)
         k = start(column)
         start(column) = k + 1
         sorted(k) = self%marks(1, i)
      end do
      kept = 0
      begin = 1
      do column = 1, n
         self%first(column) = int(kept, c_int)
         call sort_unique(sorted(begin:start(column) - 1), i)
         sorted(kept + 1:kept + i) = sorted(begin:begin + i - 1)
         kept = kept + i
         begin = start(column)
      end do
      self%first(n + 1) = int(kept, c_int)
      ! Not by assignment alone: gfortran 12 reads the bounds of what is not allocated
      if (allocated(self%row)) deallocate (self%row)
      allocate (self%row(kept), self%values(kept))
      self%row(:) = int(sorted(:kept) - 1, c_int)
      self%values = 0.0_wp
      self%n = n
      if (n <= few) then
         if (allocated(self%square)) deallocate (self%square)
         allocate (self%square(kept))
         do column = 1, n
            do k = self%first(column) + 1, self%first(column + 1)
               self%square(k) = self%row(k) + 1 + few*(column - 1)
            end do
         end do
      end if
      if (allocated(self%marks)) deallocate (self%marks)
   end subroutine analyse

   !> Sorts a short list by insertion and moves its distinct members to the front.
   pure subroutine sort_unique(list, distinct)
      integer, intent(inout) :: list(:)
      integer, intent(out) :: distinct
      integer :: i, j, item
      do i = 2, size(list)
         item = list(i)
         do j = i - 1, 1, -1
            if (list(j) <= item) exit
            list(j + 1) = list(j)
         end do
         list(j + 1) = item
      end do
      distinct = min(1, size(list))
      do i = 2, size(list)
         if (list(i) == list(distinct)) cycle
         distinct = distinct + 1
         list(distinct) = list(i)
      end do
   end subroutine sort_unique

   !> Index of an entry of the pattern among `values`.
   pure integer function place(self, row, column)
      class(sparse_type), intent(in) :: self
      integer, intent(in) :: row, column
      do place = self%first(column) + 1, self%first(column + 1)
         if (self%row(place) == row - 1) return
      end do
   end function place

   !> Whether an entry is in the pattern.
   pure logical function holds(self, row, column)
      class(sparse_type), intent(in) :: self
      integer, intent(in) :: row, column
      holds = any(self%row(self%first(column) + 1:self%first(column + 1)) == row - 1)
   end function holds

   !> Factors the present values.
   subroutine factor(self, singular)
      class(sparse_type), intent(inout) :: self
      !> True if a pivot is zero
      logical, intent(out) :: singular
      integer(c_int) :: ok
      self%factorisations = self%factorisations + 1
      singular = .false.
      if (self%n == 0) return
      if (self%n <= few) then
         call eliminate(self%n, self%square, self%values, self%dense, self%pivots, singular)
         if (self%searches == 0) self%searches = 1
         return
      end if
      if (self%n <= some) then
         call factor_own(self, singular)
         return
      end if
      if (c_associated(self%numeric)) then
         ok = klu_refactor(self%first, self%row, self%values, self%symbolic, self%numeric, self%common)
         if (ok == 1 .and. self%common%status == 0) then
            self%renewed(1) = .true.
            self%unseen(1) = self%unseen(1) - 1
            if (self%unseen(1) > 0) return
            ok = klu_rgrowth(self%first, self%row, self%values, self%symbolic, self%numeric, self%common)
            if (ok == 1) self%unseen(1) = looks(self%common%rgrowth)
            if (ok == 1 .and. self%common%rgrowth > least_growth) return
         end if
         ok = klu_free_numeric(self%numeric, self%common)
      end if
      call order(self)
      self%searches = self%searches + 1
      if (.not. allocated(self%searched)) allocate (self%searched(size(self%values)))
      self%searched(:) = self%values
      self%renewed(1) = .false.
      self%numeric = klu_factor(self%first, self%row, self%values, self%symbolic, self%common)
      singular = .not. c_associated(self%numeric) .or. self%common%status /= 0
   end subroutine factor

   !> Factors the present values of a matrix of some dozens of unknowns.
   subroutine factor_own(self, singular)
      class(sparse_type), intent(inout) :: self
      logical, intent(out) :: singular
      logical :: unfit
      singular = .false.
      if (self%own%n > 0) then
         call self%own%renew(self%values, unfit)
         self%renewed(1) = .true.
         if (.not. unfit) return
         ! Where values are no numbers no pivots are better
         singular = .not. all(abs(self%values) <= huge(1.0_wp))
         if (singular) return
      end if
      self%searches = self%searches + 1
      if (.not. allocated(self%searched)) allocate (self%searched(size(self%values)))
      self%searched(:) = self%values
      self%renewed(1) = .false.
      call self%own%seek(self%n, self%first, self%row, cmplx(self%values, 0.0_wp, wp), singular)
      if (singular) return
      call self%own%renew(self%values, singular)
   end subroutine factor_own

   !> Takes over the pivots of another matrix of the same pattern before a search of its own, if both have some dozens of unknowns:
   !> where they do not fit, others are sought.
   subroutine follow_pivots(self, other)
      class(sparse_type), intent(inout) :: self
      type(sparse_type), intent(in) :: other
      if (self%own%n > 0 .or. other%own%n == 0) return
      call self%own%follow(other%own)
      if (.not. allocated(self%searched)) allocate (self%searched(size(self%values)))
      self%searched(:) = other%searched
   end subroutine follow_pivots

   !> Factors its present complex values: at first with the pivots of the real ones.
   subroutine factor_complex_own(self, singular)
      class(sparse_type), intent(inout) :: self
      logical, intent(out) :: singular
      logical :: unfit
      singular = .false.
      if (self%complex_own%n == 0 .and. self%own%n > 0) then
         call self%complex_own%follow(self%own)
         if (.not. allocated(self%complex_searched)) allocate (self%complex_searched(size(self%complex_values)))
         self%complex_searched(:) = cmplx(self%searched, 0.0_wp, wp)
      end if
      if (self%complex_own%n > 0) then
         call self%complex_own%renew_complex(self%complex_values, unfit)
         self%renewed(2) = .true.
         if (.not. unfit) return
         singular = .not. (all(abs(real(self%complex_values, wp)) <= huge(1.0_wp)) .and. &
            & all(abs(aimag(self%complex_values)) <= huge(1.0_wp)))
         if (singular) return
      end if
      self%searches = self%searches + 1
      if (.not. allocated(self%complex_searched)) allocate (self%complex_searched(size(self%complex_values)))
      self%complex_searched(:) = self%complex_values
      self%renewed(2) = .false.
      call self%complex_own%seek(self%n, self%first, self%row, self%complex_values, singular)
      if (singular) return
      call self%complex_own%renew_complex(self%complex_values, singular)
   end subroutine factor_complex_own

   !> Factors a small matrix by Gauss: each pivot is the largest of its column beside the largest entry of its row.
   pure subroutine eliminate(n, square, values, a, pivots, singular)
      integer, intent(in) :: n
      !> Places of the entries, and the entries
      integer, contiguous, intent(in) :: square(:)
      real(wp), contiguous, intent(in) :: values(:)
      !> Receives the factors, reciprocal pivots on the diagonal
      real(wp), intent(inout) :: a(few*few)
      !> Row of the matrix that each row of the factors is
      integer, intent(inout) :: pivots(few)
      !> True if a pivot is zero
      logical, intent(out) :: singular
      real(wp) :: weight(few), largest, swap
      integer :: i, j, k, best, keep
      a(:few*n) = 0.0_wp
      do j = 1, n
         weight(j) = 0.0_wp
         pivots(j) = j
      end do
      do k = 1, size(values)
         a(square(k)) = values(k)
      end do
      do j = 1, n
         do i = 1, n
            weight(i) = max(weight(i), abs(a(i + few*(j - 1))))
         end do
      end do
      singular = .not. all(weight(:n) > 0.0_wp)
      if (singular) return
      weight(:n) = 1/weight(:n)
      do k = 1, n
         best = k
         largest = abs(a(k + few*(k - 1)))*weight(k)
         do i = k + 1, n
            if (abs(a(i + few*(k - 1)))*weight(i) <= largest) cycle
            best = i
            largest = abs(a(i + few*(k - 1)))*weight(i)
         end do
         singular = .not. largest > 0.0_wp
         if (singular) return
         if (best /= k) then
            do j = 1, n
               swap = a(k + few*(j - 1))
               a(k + few*(j - 1)) = a(best + few*(j - 1))
               a(best + few*(j - 1)) = swap
            end do
            keep = pivots(k)
            pivots(k) = pivots(best)
            pivots(best) = keep
            weight(best) = weight(k)
         end if
         a(k + few*(k - 1)) = 1/a(k + few*(k - 1))
         do i = k + 1, n
            a(i + few*(k - 1)) = a(i + few*(k - 1))*a(k + few*(k - 1))
         end do
         do j = k + 1, n
            swap = a(k + few*(j - 1))
            do i = k + 1, n
               a(i + few*(j - 1)) = a(i + few*(j - 1)) - a(i + few*(k - 1))*swap
            end do
         end do
      end do
   end subroutine eliminate

   !> Solves with these factors.
   pure subroutine substitute(n, a, pivots, b)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(few*few)
      integer, intent(in) :: pivots(few)
      !> Right-hand side, then solution (n)
      real(wp), contiguous, intent(inout) :: b(:)
      real(wp) :: x(few)
      integer :: i, j
      do i = 1, n
         x(i) = b(pivots(i))
      end do
      do j = 1, n
         do i = j + 1, n
            x(i) = x(i) - a(i + few*(j - 1))*x(j)
         end do
      end do
      do j = n, 1, -1
         x(j) = x(j)*a(j + few*(j - 1))
         do i = 1, j - 1
            x(i) = x(i) - a(i + few*(j - 1))*x(j)
         end do
         b(j) = x(j)
      end do
   end subroutine substitute

   !> Factorisations until the next look at the growth of the pivots.
   pure integer function looks(growth)
      real(wp), intent(in) :: growth
      looks = merge(seldom, 1, growth > good_growth)
   end function looks

   !> Ordering of the unknowns, once for a pattern.
   subroutine order(self)
      class(sparse_type), intent(inout) :: self
      integer(c_int) :: ok
      if (c_associated(self%symbolic)) return
      ok = klu_defaults(self%common)
      self%common%btf = 1
      self%common%scale = 2
      self%common%tol = 0.1_wp
      self%symbolic = klu_analyze(int(self%n, c_int), self%first, self%row, self%common)
   end subroutine order

   !> Factors the present complex values.
   subroutine factor_complex(self, singular)
      class(sparse_type), intent(inout) :: self
      !> True if a pivot is zero
      logical, intent(out) :: singular
      integer(c_int) :: ok
      self%factorisations = self%factorisations + 1
      singular = .false.
      if (self%n == 0) return
      if (self%n <= some) then
         call factor_complex_own(self, singular)
         return
      end if
      if (c_associated(self%complex_numeric)) then
         ok = klu_z_refactor(self%first, self%row, self%complex_values, self%symbolic, self%complex_numeric, self%common)
         if (ok == 1 .and. self%common%status == 0) then
            self%renewed(2) = .true.
            self%unseen(2) = self%unseen(2) - 1
            if (self%unseen(2) > 0) return
            ok = klu_z_rgrowth(self%first, self%row, self%complex_values, self%symbolic, self%complex_numeric, self%common)
            if (ok == 1) self%unseen(2) = looks(self%common%rgrowth)
            if (ok == 1 .and. self%common%rgrowth > least_growth) return
         end if
         ok = klu_z_free_numeric(self%complex_numeric, self%common)
      end if
      call order(self)
      self%searches = self%searches + 1
      if (.not. allocated(self%complex_searched)) allocate (self%complex_searched(size(self%complex_values)))
      self%complex_searched(:) = self%complex_values
      self%renewed(2) = .false.
      self%complex_numeric = klu_z_factor(self%first, self%row, self%complex_values, self%symbolic, self%common)
      singular = .not. c_associated(self%complex_numeric) .or. self%common%status /= 0
   end subroutine factor_complex

   !> Solves in place with the complex factors.
   subroutine solve_complex(self, b)
      class(sparse_type), intent(inout) :: self
      !> Right-hand side, then solution (n)
      complex(wp), contiguous, intent(inout) :: b(:)
      integer(c_int) :: ok
      if (self%n == 0) return
      if (self%n <= some) then
         call self%complex_own%solve_complex(b)
         return
      end if
      ok = klu_z_solve(self%symbolic, self%complex_numeric, int(self%n, c_int), 1_c_int, b, self%common)
   end subroutine solve_complex

   !> Solves in place with the factors.
   subroutine solve(self, b)
      class(sparse_type), intent(inout) :: self
      !> Right-hand side, then solution (n)
      real(wp), contiguous, intent(inout) :: b(:)
      integer(c_int) :: ok
      if (self%n == 0) return
      if (self%n <= few) then
         call substitute(self%n, self%dense, self%pivots, b)
         return
      end if
      if (self%n <= some) then
         call self%own%solve(b)
         return
      end if
      ok = klu_solve(self%symbolic, self%numeric, int(self%n, c_int), 1_c_int, b, self%common)
   end subroutine solve

   !> Gives the memory of KLU back, and forgets all factors.
   subroutine release(self)
      type(sparse_type), intent(inout) :: self
      integer(c_int) :: ok
      self%own%n = 0
      self%complex_own%n = 0
      if (c_associated(self%numeric)) ok = klu_free_numeric(self%numeric, self%common)
      if (c_associated(self%complex_numeric)) ok = klu_z_free_numeric(self%complex_numeric, self%common)
      if (c_associated(self%symbolic)) ok = klu_free_symbolic(self%symbolic, self%common)
   end subroutine release

   !> Saves or restores the values and the factors; the latter are made again in the same way, so that they are the same to the bit.
   subroutine exchange_sparse(self, snapshot)
      class(sparse_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      call snapshot%exchange('factorisations', self%factorisations)
      call snapshot%exchange('searches', self%searches)
      call snapshot%exchange('dense', self%dense)
      call snapshot%exchange('pivots', self%pivots)
      call snapshot%exchange('unseen', self%unseen)
      call snapshot%keep('values', self%values)
      if (allocated(self%complex_values)) call snapshot%exchange('complex_values', self%complex_values)
      call exchange_factors(self, snapshot)
      ! Not saved: marks, count, square, common, symbolic
   end subroutine exchange_sparse

   !> Saves or restores the factors by the values that they were made of.
   subroutine exchange_factors(self, snapshot)
      type(sparse_type), intent(inout) :: self
      type(snapshot_type), intent(inout) :: snapshot
      real(wp), allocatable :: values(:)
      complex(wp), allocatable :: complex_values(:)
      logical :: present_factors(2), renewed(2), singular
      integer :: i, searches, factorisations, unseen(2)
      present_factors = [c_associated(self%numeric) .or. self%own%n > 0, &
         & c_associated(self%complex_numeric) .or. self%complex_own%n > 0]
      renewed = self%renewed
      do i = 1, 2
         call snapshot%exchange('has_factors', present_factors(i))
         call snapshot%exchange('renewed', renewed(i))
      end do
      if (allocated(snapshot%missing)) return
      if (present_factors(1)) then
         if (.not. allocated(self%searched)) allocate (self%searched(size(self%values)), source=0.0_wp)
         call snapshot%exchange('searched', self%searched)
      end if
      if (present_factors(2)) then
         if (.not. allocated(self%complex_searched)) allocate (self%complex_searched(size(self%values)), source=(0.0_wp, 0.0_wp))
         call snapshot%exchange('complex_searched', self%complex_searched)
      end if
      if (.not. snapshot%restoring .or. allocated(snapshot%missing)) return
      searches = self%searches
      factorisations = self%factorisations
      unseen = self%unseen
      call release_factors(self)
      if (present_factors(1)) then
         allocate (values, source=self%values)
         self%values = self%searched
         call self%factor(singular)
         self%values = values
         self%unseen(1) = 2
         if (renewed(1)) call self%factor(singular)
      end if
      if (present_factors(2)) then
         allocate (complex_values, source=self%complex_values)
         self%complex_values = self%complex_searched
         ! Pivots may be those of real values: they are sought among these, and not taken over
         if (self%n <= some) call self%complex_own%seek(self%n, self%first, self%row, self%complex_searched, singular)
         call self%factor_complex(singular)
         self%complex_values = complex_values
         self%unseen(2) = 2
         if (renewed(2)) call self%factor_complex(singular)
      end if
      self%searches = searches
      self%factorisations = factorisations
      self%unseen = unseen
   end subroutine exchange_factors

   !> Forgets the factors, not the order of the unknowns.
   subroutine release_factors(self)
      class(sparse_type), intent(inout) :: self
      integer(c_int) :: ok
      self%own%n = 0
      self%complex_own%n = 0
      if (c_associated(self%numeric)) ok = klu_free_numeric(self%numeric, self%common)
      if (c_associated(self%complex_numeric)) ok = klu_z_free_numeric(self%complex_numeric, self%common)
   end subroutine release_factors

end module limber_multibody_sparse_matrix
